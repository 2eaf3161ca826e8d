from pathlib import Path

import pytest

from gpu.errors import UserError
from gpu.scene.lighting.environment_options import NO_ENVIRONMENT, EnvironmentOptions
from gpu.settings import Method, Quality, RenderSettings
from server.settings import ServerSettings, load_settings, unknown_names


def test_loopback_is_the_default() -> None:
    assert load_settings().host == "127.0.0.1"


def test_flags_win_over_the_environment_which_wins_over_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "lumenwalk.toml"
    file.write_text('port = 1001\nhost = "::1"\nmax_viewers = 3\n[scene_limits]\nmax_triangles = 5\nmax_lights = 6\n')
    monkeypatch.setenv("LUMENWALK_PORT", "1002")
    monkeypatch.setenv("LUMENWALK_HOST", "0.0.0.0")
    monkeypatch.setenv("LUMENWALK_SCENE_LIMITS__MAX_TRIANGLES", "7")
    settings = load_settings(file, {"port": 1003, "host": None})
    assert (settings.port, settings.host, settings.max_viewers) == (1003, "0.0.0.0", 3)
    assert (settings.scene_limits.max_triangles, settings.scene_limits.max_lights) == (7, 6)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("port = 70000", "port"),
        ("prt = 1", "prt"),
        ("port = ", "not a TOML file"),
        ("[scene_limits]\nmax_triangles = 0", "scene_limits.max_triangles"),
    ],
)
def test_a_wrong_file_is_refused_with_the_place(tmp_path: Path, text: str, complaint: str) -> None:
    file = tmp_path / "lumenwalk.toml"
    file.write_text(text)
    with pytest.raises(UserError, match=f"lumenwalk.toml: {complaint}"):
        load_settings(file)


def test_a_wrong_flag_is_not_said_to_be_of_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "lumenwalk.toml"
    file.write_text("port = 9000\nmax_viewers = 8")
    with pytest.raises(UserError, match=r"^settings: port"):
        load_settings(file, {"port": 70000})
    monkeypatch.setenv("LUMENWALK_MAX_VIEWERS", "0")
    with pytest.raises(UserError, match=r"^settings: max_viewers"):
        load_settings(file)
    monkeypatch.delenv("LUMENWALK_MAX_VIEWERS")
    file.write_text("[scene_limits]\nmax_lights = 6")
    monkeypatch.setenv("LUMENWALK_SCENE_LIMITS__MAX_TRIANGLES", "many")
    with pytest.raises(UserError, match=r"^settings: scene_limits\.max_triangles"):
        load_settings(file)


def test_what_the_environment_has_that_is_no_setting_is_told() -> None:
    of_kubernetes = ("LUMENWALK_SERVICE_HOST", "LUMENWALK_PORT_8000_TCP", "LUMENWALK_ASSIGN_SERVICE_PORT_HTTP")
    settings = ("LUMENWALK_PORT", "lumenwalk_host", "LUMENWALK_SCENE_LIMITS__MAX_LIGHTS", "LUMENWALK_SCENE_LIMITS")
    wrong = ("LUMENWALK_MAXVIEWERS", "LUMENWALK_SCENE_LIMIT__MAX_LIGHTS")
    assert unknown_names(("PATH", *of_kubernetes, *settings, *wrong)) == sorted(wrong)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="no such settings file"):
        load_settings(tmp_path / "gone.toml")


def test_a_wrong_environment_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LUMENWALK_SCENE_LIMITS", "{")
    with pytest.raises(UserError, match="scene_limits"):
        load_settings()


def test_every_setting_says_what_it_is() -> None:
    assert [name for name, field in ServerSettings.model_fields.items() if not field.description] == []


@pytest.mark.parametrize(
    "name", ["samples", "vpls", "vpl_clusters", "sp_clusters", "photons", "gather_rays", "caustic_photons"]
)
def test_counts_have_limits_of_the_service(name: str) -> None:
    settings = ServerSettings(**{f"max_{name}": 10})
    settings.check_render((8, 8), RenderSettings(**{name: 10}), 64)
    with pytest.raises(UserError, match=rf"settings\.{name}: 11"):
        settings.check_render((8, 8), RenderSettings(**{name: 11}), 64)


def test_pixels_have_a_limit() -> None:
    with pytest.raises(UserError, match="size: 8×9 is 72 pixels"):
        ServerSettings().check_render((8, 9), RenderSettings(), 71)


def test_names_come_as_a_list_or_with_commas(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "lumenwalk.toml"
    file.write_text('allowed_hosts = ["One.example", "two.example"]')
    monkeypatch.setenv("LUMENWALK_ALLOWED_ORIGINS", "https://One.example, http://two.example:81")
    settings = load_settings(file)
    assert settings.allowed_hosts == ("one.example", "two.example")
    assert settings.allowed_origins == ("https://one.example", "http://two.example:81")


@pytest.mark.parametrize("token", ["too-short", "with a space in the middle", "ünïcödé-ünïcödé-ünïcödé"])
def test_a_token_that_is_weak_or_cannot_be_sent_is_refused_without_being_shown(token: str) -> None:
    with pytest.raises(UserError, match=r"token: .*16 or more") as info:
        load_settings(flags={"token": token})
    assert token not in str(info.value)


def test_an_empty_variable_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LUMENWALK_TOKEN", "")
    assert load_settings().token is None


@pytest.mark.parametrize("target", [{"target_ms": 10.0}, {"target_error": 1e-3}])
def test_a_target_is_refused_where_it_could_take_more_clusters_than_allowed(target: dict[str, float]) -> None:
    settings = RenderSettings(**target)
    ServerSettings().check_render((8, 8), settings, 64)
    with pytest.raises(UserError, match="131072 sp_clusters, more than this server's limit of 1000; ask for counts"):
        ServerSettings(max_sp_clusters=1000).check_render((8, 8), settings, 64)
    with pytest.raises(UserError, match="more than this server's limit of 9999"):
        ServerSettings(max_vpls=9999).check_render((8, 8), settings, 64)


def test_the_best_quality_keeps_to_the_limits() -> None:
    best = RenderSettings(quality=Quality.BEST)
    ServerSettings().check_render((8, 8), best, 64)
    server = ServerSettings(max_vpls=100_000)
    with pytest.raises(UserError, match=r"quality: best takes up to 196608 vpls, more than .* limit of 100000"):
        server.check_render((8, 8), best, 64)
    server.check_render((8, 8), RenderSettings(quality=Quality.BEST, vpls=100_000), 64)
    paths = best.model_copy(update={"method": Method.PATH})
    with pytest.raises(UserError, match=r"quality: best takes up to 128 samples, more than .* limit of 100"):
        ServerSettings(max_samples=100).check_render((8, 8), paths, 64)
    with pytest.raises(UserError, match=r"quality: balanced takes up to 64 samples, more than .* limit of 10"):
        ServerSettings(max_samples=10).check_render((8, 8), RenderSettings(method=Method.PATH), 64)
    ServerSettings(max_samples=10).check_render((8, 8), RenderSettings(method=Method.PATH, samples=10), 64)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("allowed_origins", "portal.example.org", "no origin: write scheme, host and port"),
        ("allowed_hosts", "https://walk.example.org", "no name of a host"),
        ("trusted_proxies", "proxy", "no address"),
        ("root_path", "walk", "no path prefix: write it as /walk"),
    ],
)
def test_addresses_that_make_no_sense_are_said_at_the_start(name: str, value: str, words: str) -> None:
    with pytest.raises(UserError, match=f"{name}.*{words}"):
        load_settings(flags={name: value})


def test_what_is_around_every_scene_is_a_setting_of_the_service(tmp_path: Path) -> None:
    file = tmp_path / "lumenwalk.toml"
    file.write_text('environment = "sky.exr"\nenvironment_rotation = 30\n')
    around = load_settings(file, {"environment_strength": 2.0}).surroundings
    expected = EnvironmentOptions(environment=Path("sky.exr"), environment_rotation=30.0, environment_strength=2.0)
    assert around == expected
    assert ServerSettings().surroundings == NO_ENVIRONMENT
