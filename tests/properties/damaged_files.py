"""Read damaged files within limits of the processor's time and of memory; print what is neither read nor refused.

Run as a program with the number of files of each kind and the first seed.
"""

import base64
import contextlib
import io
import json
import re
import resource
import signal
import sys
import tempfile
import time
import zlib
from pathlib import Path

import ezdxf
import meshio
import numpy as np

from flangeway.cases.case_file import read_case
from flangeway.errors import FlangewayError
from flangeway.formats import read_mesh, read_section, write_vtu
from flangeway.mesh.structured import rectangle_grid

SECONDS, BYTES = 4, 1_500_000_000
HUGE = [b"99999999999", b"-1", b"0", b"1e308", b"nan", b"4294967295", b"1_0", b"2147483648", b"\xff\xfe", b"%n"]
POINTS = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0]])
OUTLINE = """unit = "mm"
[outer]
points = [[0, 0], [9, 0, 1], [9, 9], [0, 9]]
[[holes]]
circle = { centre = [4, 4], radius = 1 }
"""
CASE = """case = "two-bodies"
[[bodies]]
name = "a"
rectangle = { width_mm = 1.0, height_mm = 1.0 }
[[supports]]
body = "a"
"""
DECK = """*HEADING
*NODE
1, 0, 0
2, 1, 0
3, 2, 0
4, 0, 1
5, 1, 1
6, 2, 1
*ELEMENT, TYPE=CPE4, ELSET=ALL
1, 1, 2, 5, 4
2, 2, 3, 6, 5
*NSET, NSET=LOW, GENERATE
1, 3, 1
*SURFACE, NAME=TOP
ALL, S3
"""


def sound_files(folder):
    """Small files without a fault, by their names."""
    files = {"a.toml": OUTLINE.encode(), "case.toml": CASE.encode(), "a.inp": DECK.encode()}
    files["a.csv"] = b"x_mm,y_mm\n0,0\n9,0\n9,9\n0,9\n"
    drawing, text = ezdxf.new("R12"), io.StringIO()
    space = drawing.modelspace()
    space.add_polyline2d([(0, 0, 0), (10, 0, 1), (10, 4, 0), (0, 4, 1)], format="xyb", close=True)
    drawing.blocks.new("hole").add_circle((0, 0), 1)
    space.add_blockref("hole", (5, 2))
    drawing.write(text)
    files["a.dxf"] = text.getvalue().encode()
    mesh = meshio.Mesh(POINTS, [("quad", np.array([[0, 1, 4, 3], [1, 2, 5, 4]])), ("line", np.array([[0, 1]]))])
    mesh.cell_data = {
        "gmsh:physical": [np.array([1, 2]), np.array([3])],
        "gmsh:geometrical": [np.array([1, 2]), np.array([3])],
    }
    grid = meshio.Mesh(POINTS, mesh.cells[:1], cell_data={name: parts[:1] for name, parts in mesh.cell_data.items()})
    for version in ("2.2", "4.0", "4.1"):
        for binary in (True, False):
            file = folder / "sound.msh"
            with contextlib.redirect_stdout(io.StringIO()):
                meshio.gmsh.write(str(file), grid, version, binary=binary)
            files[f"{version}_{binary}.msh"] = file.read_bytes()
    for name, options in {
        "a.mesh": {},
        "a.meshb": {},
        "a.vtk": {},
        "t.vtk": {"binary": False},
        "a.vtu": {},
        "t.vtu": {"binary": False},
    }.items():
        file = folder / name
        with contextlib.redirect_stdout(io.StringIO()):
            meshio.write(file, mesh, **options)
        files[name] = file.read_bytes()
    write_vtu(folder / "own.vtu", rectangle_grid(1.0, 1.0, 2, 2))
    files["own.vtu"] = (folder / "own.vtu").read_bytes()
    return files


def damaged(content, name, rng):
    """Content with numbers replaced, bytes changed, and parts cut out or doubled."""
    data = bytearray(content)
    first = max(content.rfind(b"ENTITIES"), 0) if name.endswith("dxf") else 0
    for _ in range(int(rng.integers(1, 4))):
        place = first + int(rng.integers(len(data) - first)) if len(data) > first else 0
        kind = int(rng.integers(5))
        if kind <= 1:
            numbers = list(re.finditer(rb"\d+", bytes(data[first:])))
            if numbers:
                one = numbers[int(rng.integers(len(numbers)))]
                data[first + one.start() : first + one.end()] = HUGE[int(rng.integers(len(HUGE)))]
        elif kind == 2:
            data[place : place + 1] = bytes([int(rng.integers(256))])
        elif kind == 3:
            del data[place : place + int(rng.integers(1, 60))]
        else:
            data[place:place] = data[place : place + int(rng.integers(1, 200))] * int(rng.integers(1, 20))
    return bytes(data)


def zeros_packed(millions):
    """Millions of zeros as zlib packs them: one million, which needs nothing before it, again and again."""
    packer = zlib.compressobj(1, zlib.DEFLATED, -zlib.MAX_WBITS)
    million = packer.compress(bytes(10**6)) + packer.flush(zlib.Z_FULL_FLUSH)
    checksum = (millions * 10**6 % 65521 << 16) + 1  # Adler-32: the sum of sums counts the one before the zeros
    return b"\x78\x01" + millions * million + packer.flush() + checksum.to_bytes(4, "big")


def bombs():
    """Files that say, or pack, far more than they are."""
    block = zeros_packed(1_000)
    header = np.array([1, 1_000_000_000, 0, len(block)], dtype="<u4").tobytes()
    array = (base64.b64encode(header) + base64.b64encode(block)).decode()
    yield "packed.vtu", (
        '<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian" '
        'compressor="vtkZLibDataCompressor"><UnstructuredGrid><Piece NumberOfPoints="4000000000" NumberOfCells="1">'
        f'<Points><DataArray type="Float64" Name="Points" NumberOfComponents="3" format="binary">{array}</DataArray>'
        "</Points></Piece></UnstructuredGrid></VTKFile>"
    ).encode()  # fmt: skip
    entities = b"".join(b'<!ENTITY b%d "' % n + b"&b%d;" % (n - 1) * 100 + b'">' for n in range(1, 9))
    start = b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b0 "' + b"x" * 1000 + b'">'
    yield "entities.vtu", start + entities + b"]><VTKFile>&b8;</VTKFile>"
    yield "deep.vtu", b"<VTKFile>" + b"<a>" * 500_000
    yield "deep.toml", b"a = " + b"[" * 1_000_000
    yield "dotted.toml", b"a." * 100_000 + b"a = 1"
    for count in (10**8, 10**12, 2**31 - 1):
        number = b"%d" % count
        yield f"{count}.msh", b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + number + b"\n1 0 0 0\n$EndNodes\n"
        yield (
            f"e{count}.msh",
            (b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n$EndNodes\n$Elements\n" + number + b"\n"),
        )
        for version in (b"4.0", b"4.1"):
            rows = number + b" " + number + b" 1 " + number
            yield f"{version}{count}.msh", b"$MeshFormat\n" + version + b" 0 8\n$EndMeshFormat\n$Nodes\n" + rows + b"\n"
            entities = b"$Entities\n" + b" ".join([number] * 4) + b"\n"
            yield f"t{version}{count}.msh", b"$MeshFormat\n" + version + b" 0 8\n$EndMeshFormat\n" + entities
        yield f"p{count}.msh", b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n" + number + b"\n"
        for word in (b"Vertices", b"Triangles", b"Corners", b"RequiredVertices"):
            yield f"{word}{count}.mesh", b"MeshVersionFormatted 2\nDimension 2\n" + word + b"\n" + number + b"\n0 0 1\n"
        for word in (b"POINTS %d float", b"CELLS %d %d", b"CELL_TYPES %d"):
            row = word.replace(b"%d", number)
            yield (
                f"{count}{word}.vtk".replace("%", ""),
                (
                    b"# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 1 float\n0 0 0\n"
                    + row
                    + b"\n1 2\n"
                ),
            )
    yield "wide.csv", b"x_mm,y_mm\n" + b"1," * 2_000_000
    yield (
        "long.inp",
        b"*NODE\n1,0,0\n*NSET, NSET=A\n1,\n"
        + b"".join(b"*NSET, NSET=%d\n%d,%d\n" % (n, n - 1, n - 1) for n in range(9)),
    )
    yield "continued.inp", b"*NODE,\n" * 200_000
    yield (
        "blocks.dxf",
        b"  0\nSECTION\n  2\nENTITIES\n"
        + b"  0\nINSERT\n  2\nA\n 70\n30000\n 71\n30000\n" * 10
        + b"  0\nENDSEC\n  0\nEOF\n",
    )


def read(file):
    if file.name.startswith(("case", "deep.toml", "dotted")):
        read_case(file)
    elif file.suffix in (".toml", ".csv", ".dxf"):
        read_section(file, unit=None if file.suffix == ".toml" else "mm")
    else:
        read_mesh(file)


def late(*_):
    raise TimeoutError("too long")


def outcome(file):
    """Nothing if a file is read or refused in time, with a message of a reasonable length; otherwise the fault."""
    start = time.process_time()
    signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS)
    try:
        read(file)
    except FlangewayError as error:
        if len(str(error)) > 4000:
            return f"a message of {len(str(error))} letters"
    except BaseException as error:
        return f"{type(error).__name__}: {str(error)[:200]}"
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
    seconds = time.process_time() - start
    return f"{seconds:.1f} s" if seconds > SECONDS else ""


def main(n_files, seed):
    held = int(re.search(r"VmSize:\s+(\d+)", Path("/proc/self/status").read_text())[1]) * 1024
    resource.setrlimit(resource.RLIMIT_AS, (held + BYTES, held + BYTES))
    signal.signal(signal.SIGVTALRM, late)
    faults, n_read = {}, 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        sound = sound_files(folder)
        rng = np.random.default_rng(seed)
        jobs = [(name, content) for name, content in sound.items()]
        jobs += [(name, damaged(content, name, rng)) for name, content in sound.items() for _ in range(n_files)]
        jobs += list(bombs())
        for number, (name, content) in enumerate(jobs):
            file = folder / re.sub(r"[^\w.]", "_", name)
            file.write_bytes(content)
            fault = outcome(file)
            n_read += 1
            if fault:
                faults[f"{number} {file.name}"] = fault
                if len(sys.argv) > 3:
                    Path(sys.argv[3], f"{number}_{file.name}").write_bytes(content)
    print(json.dumps({"read": n_read, "faults": faults}, indent=1))


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
