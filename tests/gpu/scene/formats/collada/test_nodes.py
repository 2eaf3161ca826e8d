from pathlib import Path

import numpy as np
import pytest
from dae_file import dae, use

from gpu.errors import SceneError
from gpu.scene.formats.collada.document import open_document
from gpu.scene.formats.collada.nodes import placed_instances
from gpu.scene.limits import DEFAULT_LIMITS


def matrices(folder: Path, *nodes: str, **changes: str) -> list[np.ndarray]:
    path = folder / "a.dae"
    path.write_bytes(dae(nodes, **changes))
    return [instance.to_world for instance in placed_instances(open_document(path, DEFAULT_LIMITS))]


@pytest.mark.parametrize(
    ("transform", "moved"),
    [
        ("", (1, 2, 3)),
        ("<translate>10 20 30</translate>", (11, 22, 33)),
        ("<rotate>0 0 2 90</rotate>", (-2, 1, 3)),
        ("<rotate>0 0 0 90</rotate>", (1, 2, 3)),
        ("<scale>2 3 4</scale>", (2, 6, 12)),
        ("<translate>10 0 0</translate><rotate>0 0 1 90</rotate><scale>2 2 2</scale>", (6, 2, 6)),
        ("<matrix>1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1</matrix>", (6, 8, 10)),
        ("<skew>45 0 1 0 1 0 0</skew>", (3, 2, 3)),
        ("<lookat>0 0 10  0 0 0  0 1 0</lookat>", (1, 2, 13)),
    ],
)
def test_transforms(tmp_path: Path, transform: str, moved: tuple[float, ...]) -> None:
    (matrix,) = matrices(tmp_path, f"<node>{transform}{use()}</node>")
    np.testing.assert_allclose(matrix @ [1, 2, 3, 1], [*moved, 1], atol=1e-12)


def test_nodes_of_the_library_are_used_within_others(tmp_path: Path) -> None:
    library = f'<library_nodes><node id="n"><translate>1 0 0</translate>{use()}</node></library_nodes>'
    inner = '<node><translate>0 10 0</translate><instance_node url="#n"/></node><instance_node url="#n"/>'
    found = matrices(tmp_path, f"<node><translate>100 0 0</translate>{inner}</node>", libraries=library)
    assert [matrix[:3, 3].tolist() for matrix in found] == [[101, 10, 0], [101, 0, 0]]


def test_x_up_is_turned(tmp_path: Path) -> None:
    (matrix,) = matrices(tmp_path, f"<node>{use()}</node>", asset="<up_axis>X_UP</up_axis>")
    assert (matrix @ [1, 2, 3, 1]).tolist() == [-2, 1, 3, 1]


@pytest.mark.parametrize(
    ("node", "says"),
    [
        ('<node name="n"><translate>1 2</translate></node>', "n: translate: needs 3 numbers, not 2"),
        ('<node name="n"><scale>1 1 a</scale></node>', "n: scale: needs numbers"),
        ('<node name="n"><translate>1 2 INF</translate></node>', r"n: translate\[2\]: is not finite"),
        ('<node id="n"><instance_node url="#n"/></node>', "n: it contains itself"),
    ],
)
def test_what_is_broken_is_refused(tmp_path: Path, node: str, says: str) -> None:
    with pytest.raises(SceneError, match=says):
        matrices(tmp_path, node)
