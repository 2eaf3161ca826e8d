from pathlib import Path

from server.cli.reference import PAGE, main, reference


def test_the_page_of_options_is_up_to_date() -> None:
    assert PAGE.read_text() == reference(), "run `make docs`"


def test_the_page_is_written_where_it_is_asked_for(tmp_path: Path) -> None:
    page = tmp_path / "options.md"
    assert main(page) == 0
    assert page.read_text() == reference()


def test_defaults_and_limits_are_in_words() -> None:
    text = reference()
    assert "| `--fuzziness` | 6 | 1 to 8 |" in text
    methods = "`fuzzy-vpl`, `exact-vpl`, `photon-gather`, `path`, `rsm-disks`"
    assert f"| `--method` | `fuzzy-vpl` | {methods} |" in text
    assert "| `--vpls` | 98304 | 8192 |" in text
    assert "| `--reserve-bytes` | 512 MiB |" in text
    assert "| `--uploads`, `--no-uploads` | on |" in text
