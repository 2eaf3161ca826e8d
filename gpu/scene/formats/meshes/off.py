"""OFF files, text and binary, with colours and normals of vertices (COFF, NOFF, …) and colours of faces."""

import re
import struct

import numpy as np

from gpu.errors import SceneError
from gpu.scene.floats import doubles
from gpu.scene.formats.mesh_colors import linear_colors
from gpu.scene.formats.outlines import FaceMesh, face_part, whole
from gpu.scene.formats.text import decoded, numbers, uncommented, without_mark
from gpu.scene.remarks import Remarks
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Doubles, Integers

_KEYWORD = re.compile(r"(ST)?(C)?(N)?OFF", re.IGNORECASE)
_BINARY = re.compile(rb"\s*(\w*OFF)[ \t]+BINARY[^\n]*\n", re.IGNORECASE)
_HEADER = "OFF header"


class OffFile:
    """One OFF file while it is read. kinds: what its keyword says that vertices have: ST, C, N."""

    def __init__(self, source: str, keyword: str, remarks: Remarks) -> None:
        """Raises SceneError for a keyword of other than three dimensions."""
        self.source, self.remarks = source, remarks
        match = _KEYWORD.fullmatch(keyword)
        if match is None or keyword.startswith("n"):
            raise SceneError(source, _HEADER, f"{keyword!r:.20} is not OFF, COFF, NOFF or STOFF, in three dimensions")
        self.coordinates, self.colored, self.shaded = (group is not None for group in match.groups())

    def part(self, vertices: Doubles, corners: Integers, counts: Integers, colors: Doubles | None) -> MeshPart:
        """The part of `vertices` (vertex, number) and faces. colors (face, 3 or 4): as the file has them."""
        after = vertices[:, 3:]
        normals = after[:, :3] if self.shaded else None
        after = after[:, 3 if self.shaded else 0 : -2 if self.coordinates else None]
        colored = after.shape[1] in (3, 4)
        if self.coordinates or (after.shape[1] and not colored):
            self.remarks.add("texture coordinates or other numbers of vertices were ignored")
        mesh = FaceMesh(
            vertices[:, :3],
            corners,
            counts,
            normals,
            linear_colors(after, self.remarks) if colored else None,
            None if colors is None else linear_colors(colors, self.remarks),
        )
        return face_part(self.source, mesh, self.remarks)


def read_off(source: str, content: bytes, remarks: Remarks) -> MeshPart:
    """The faces of an OFF file. Raises SceneError when it is cut off or no OFF file."""
    content = without_mark(content)
    binary = _BINARY.match(content)
    if binary:
        return _binary(OffFile(source, binary[1].decode("ascii", "replace"), remarks), content[binary.end() :])
    text = decoded(content)
    lines = [line for line in (uncommented(line).strip() for line in text.split("\n")) if line]
    keyword = re.match(r"[A-Za-z4]\S*", lines[0]) if lines else None
    file = OffFile(source, keyword[0] if keyword else "OFF", remarks)
    if keyword:
        lines[0] = lines[0][keyword.end() :].strip()
        lines = lines if lines[0] else lines[1:]
    try:
        vertices, faces = (int(word) for word in " ".join(lines[:2]).split()[:2])
    except ValueError as error:
        raise SceneError(source, _HEADER, "does not say how many vertices and faces follow") from error
    if min(vertices, faces) < 0 or len(lines) - 1 < vertices + faces or len(lines[0].split()) < 2:
        lines = _one_a_line(file, " ".join(lines).split(), vertices, faces, len(lines) - 1)
    found = len(lines) - 1
    remarks.add_count("lines after the last face were ignored", found - vertices - faces)
    rows = _vertices(file, lines[1 : 1 + vertices])
    return file.part(rows, *_faces(file, lines[1 + vertices : 1 + vertices + faces]))


def _one_a_line(file: OffFile, words: list[str], vertices: int, faces: int, found: int) -> list[str]:
    """Lines for a file that has several vertices or faces on one; faces have no colours there.

    words: all that is in the file's `found` lines after the header's.
    Raises SceneError where the numbers are not as many as the header says.
    """
    width = 3 + 3 * file.shaded + 4 * file.colored + 2 * file.coordinates
    lines, at = [" ".join(words[:3])], 3
    try:
        if min(vertices, faces) < 0 or at + width * vertices + faces > len(words):
            raise ValueError
        for _ in range(vertices):
            lines.append(" ".join(words[at : at + width]))
            at += width
        for _ in range(faces):
            corners = int(words[at])
            lines.append(" ".join(words[at : at + 1 + corners]))
            at += 1 + corners
        if at != len(words):
            raise ValueError
    except (IndexError, ValueError) as error:
        said = (
            f"{vertices} vertices and {faces} faces, but only {found} lines follow, and other numbers than these have"
        )
        raise SceneError(file.source, _HEADER, said) from error
    return lines


def _vertices(file: OffFile, lines: list[str]) -> Doubles:
    """The numbers (vertex, number) of the vertices' lines, as many as each has."""
    values, widths = _numbers(file, lines, "vertex")
    least = 6 if file.shaded else 3
    if len(widths) and widths.min() < least:
        row = int(np.argmax(widths < least))
        raise SceneError(file.source, f"vertex {row}", f"needs {least} numbers, not {lines[row]!r:.60}")
    width = int(widths.min()) if len(widths) else 3
    if (widths > width).any():
        file.remarks.add_count(
            f"vertices have more numbers than the {width} that all have", int((widths > width).sum())
        )
    return values[(np.cumsum(widths) - widths)[:, None] + np.arange(width)]


def _faces(file: OffFile, lines: list[str]) -> tuple[Integers, Integers, Doubles | None]:
    """Corners (corner,), how many each face has (face,), and the faces' colours (face, 4) where any has one."""
    values, widths = _numbers(file, lines, "face")
    starts = np.cumsum(widths) - widths
    said = values[starts] if len(widths) else values
    wrong = ~((said >= 0) & (said < widths) & (said == np.floor(said)))
    if wrong.any():
        row = int(np.argmax(wrong))
        raise SceneError(file.source, f"face {row}", f"{said[row]:g} corners, but {lines[row]!r:.60} has not as many")
    counts = said.astype(np.int64)
    owner = np.repeat(np.arange(len(widths)), widths)
    place = np.arange(len(values)) - starts[owner]
    corners = values[(place > 0) & (place <= counts[owner])]
    extra = widths - 1 - counts
    colored = (extra == 3) | (extra == 4)
    file.remarks.add_count(
        "faces have an entry of a colour map, or other numbers, that was ignored", int((~colored & (extra > 0)).sum())
    )
    if not colored.any():
        return whole(corners), counts, None
    white = 255.0 if (values[(place > counts[owner]) & colored[owner]] > 1.0).any() else 1.0
    colors = np.full((len(widths), 4), white)
    for channel in range(4):
        some = colored & (extra > channel)
        colors[some, channel] = values[starts[some] + counts[some] + 1 + channel]
    return whole(corners), counts, colors


def _numbers(file: OffFile, lines: list[str], what: str) -> tuple[Doubles, Integers]:
    """All numbers (number,) of lines, and how many each has (line,)."""
    try:
        return numbers(word for line in lines for word in line.split()), np.array(
            [len(line.split()) for line in lines], np.int64
        )
    except ValueError as error:
        raise SceneError(file.source, what, f"needs numbers, with points for decimals: {error}") from error


def _binary(file: OffFile, content: bytes) -> MeshPart:
    """The part of what follows the header of a binary file: big-endian numbers of 4 bytes."""
    try:
        vertices, faces, _ = struct.unpack_from(">3i", content)
        if min(vertices, faces) < 0 or faces > len(content) // 8:  # a face has two counts of 4 bytes
            raise ValueError
        width = 3 + 3 * file.shaded + 4 * file.colored + 2 * file.coordinates
        rows = doubles(np.frombuffer(content, ">f4", vertices * width, 12).reshape(vertices, width))
        at = 12 + rows.size * 4
        corners, counts, colors = [], [], np.ones((faces, 4))
        any_color = False
        for face in range(faces):
            (count,) = struct.unpack_from(">I", content, at)
            corners.append(np.frombuffer(content, ">i4", count, at + 4))
            at += 4 + 4 * count
            (channels,) = struct.unpack_from(">I", content, at)
            color = np.frombuffer(content, ">f4", channels, at + 4)
            at += 4 + 4 * channels
            counts.append(count)
            if channels in (3, 4):
                colors[face, :channels] = doubles(color)
                any_color = True
    except (struct.error, ValueError, MemoryError) as error:
        raise SceneError(file.source, "", "the counts do not fit the file, which is cut off or broken") from error
    ids = np.concatenate([np.empty(0, np.int64), *corners])
    return file.part(rows, ids.astype(np.int64), np.array(counts, np.int64), colors if any_color else None)
