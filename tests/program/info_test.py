"""brim info of a volume: histogram, windows that part what is in it, and a picture of its slices; of a scene: mass and size of
its bodies. BRIM_PROGRAM names the program."""
import json
import os
import pathlib
import re
import struct
import subprocess
import tempfile
import unittest
import zlib

BRIM = os.environ["BRIM_PROGRAM"]


def read_png(path):
    """(width, height, rows) of a greyscale PNG, checked as readers do."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed, size = 8, b"", None
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        assert zlib.crc32(kind + body) == struct.unpack(">I", data[at + 8 + length:at + 12 + length])[0]
        if kind == b"IHDR":
            size = struct.unpack(">IIBB", body[:10])
        if kind == b"IDAT":
            packed += body
        at += 12 + length
    raw = zlib.decompress(packed)
    width, height, depth, colour = size
    assert (depth, colour) == (8, 0) and len(raw) == height * (width + 1)
    return width, height, [raw[y * (width + 1) + 1:(y + 1) * (width + 1)] for y in range(height)]


def dicom_slice(series, z, rows, columns, values):
    """A slice of a CT in explicit little-endian, with Hounsfield's zero at 1024."""
    def element(group, number, kind, value):
        value += (b"\0" if kind == "UI" else b" ") * (len(value) % 2)
        length = struct.pack("<2xI" if kind == "OW" else "<H", len(value))
        return struct.pack("<HH", group, number) + kind.encode() + length + value

    def whole(n):
        return struct.pack("<H", n)
    meta = (element(2, 2, "UI", b"1.2.840.10008.5.1.4.1.1.2") + element(2, 3, "UI", b"1.2.3") +
            element(2, 0x10, "UI", b"1.2.840.10008.1.2.1"))
    return (b"\0" * 128 + b"DICM" + element(2, 0, "UL", struct.pack("<I", len(meta))) + meta +
            element(8, 0x16, "UI", b"1.2.840.10008.5.1.4.1.1.2") + element(8, 0x60, "CS", b"CT") +
            element(0x20, 0xe, "UI", series.encode()) + element(0x20, 0x32, "DS", f"0\\0\\{z}".encode()) +
            element(0x20, 0x37, "DS", b"1\\0\\0\\0\\1\\0") + element(0x28, 2, "US", whole(1)) +
            element(0x28, 4, "CS", b"MONOCHROME2") + element(0x28, 0x10, "US", whole(rows)) +
            element(0x28, 0x11, "US", whole(columns)) + element(0x28, 0x30, "DS", b"5\\5") +
            element(0x28, 0x100, "US", whole(16)) + element(0x28, 0x101, "US", whole(12)) +
            element(0x28, 0x102, "US", whole(11)) + element(0x28, 0x103, "US", whole(0)) +
            element(0x28, 0x1052, "DS", b"-1024") + element(0x28, 0x1053, "DS", b"1") +
            element(0x7fe0, 0x10, "OW", struct.pack(f"<{rows * columns}H", *(v + 1024 for v in values))))


class Info(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        n = 20
        # Air, a ball of soft tissue in it, a ball of bone in that.
        values = self.values = []
        for k in range(n):
            for j in range(n):
                for i in range(n):
                    r = ((i - 9.5) ** 2 + (j - 9.5) ** 2 + (k - 9.5) ** 2) ** 0.5
                    values.append((1200 if r < 4 else 40 if r < 8 else -1000) + (7 * i + 3 * j + k) % 11 - 5)
        (self.root / "head.nrrd").write_bytes(b"NRRD0004\ntype: short\ndimension: 3\nsizes: 20 20 20\nspacings: 5 5 5\n"
                                              b"endian: little\nencoding: raw\n\n" + struct.pack(f"<{n**3}h", *values))

    def brim(self, *words, file="head.nrrd"):
        return subprocess.run([BRIM, "info", file, *words], capture_output=True, text=True, cwd=self.root, check=True).stdout

    def write_dicom(self, series):
        folder = self.root / "scans" / series
        folder.mkdir(parents=True)
        for k in range(20):
            (folder / f"IM{7 * k % 20}").write_bytes(dicom_slice(series, 5 * k, 20, 20, self.values[400 * k:400 * (k + 1)]))

    def test_windows_part_what_is_in_the_volume(self):
        out = self.brim()
        windows = [tuple(map(float, m)) for m in re.findall(r"window \[([-\d.e+]+), ([-\d.e+]+)\]", out)]
        self.assertEqual(len(windows), 2, out)
        self.assertTrue(-990 < windows[0][0] < windows[0][1] < 30, out)
        self.assertTrue(50 < windows[1][0] < windows[1][1] < 1190, out)
        self.assertIn("Hounsfield", out)
        shares = [float(m) for m in re.findall(r"# +([\d.e+-]+) %", out)]
        self.assertAlmostEqual(sum(shares), 100, delta=2)

    def test_a_scene_tells_mass_and_size_of_each_body(self):
        box = {"kind": "rigid", "shape": {"kind": "box", "size": [0.1, 0.2, 0.4]}, "density": 500}
        scene = {"brim": 1, "name": "s", "frames": 1, "bodies": [
            {"kind": "obstacle", "name": "floor", "shape": {"kind": "plane", "display_size": 2}},
            {**box, "name": "box", "voxel_size": 0.02},
            {**box, "name": "brick", "repeat": {"count": [1, 1, 3], "spacing": [1, 1, 1]}},
            {"kind": "particle_fluid", "name": "drop", "spacing": 0.04, "shape": {"kind": "sphere", "radius": 0.1}},
            {"kind": "grid_fluid", "name": "pond", "cell_size": 0.1, "box": {"lo": [0, 0, 0], "hi": [1, 1, 1]},
             "fill": [{"kind": "plane", "point": [0, 0, 0.5], "normal": [0, 0, 1]}]},
            {"kind": "image_volume", "name": "slip", "file": "head.nrrd", "window": [-500, -500], "unit": 1}]}
        (self.root / "s.json").write_text(json.dumps(scene))
        lines = [line.strip() for line in self.brim(file="s.json").splitlines()]
        self.assertIn("box: rigid, 4 kg, 0.008 m³, 0.1 x 0.2 x 0.4 m, voxels of 0.02 m, 7 coordinates", lines)
        self.assertTrue(any(line.startswith("floor: obstacle, 2 x 2 x 0 m") for line in lines), lines)
        self.assertTrue(any(line.startswith("brick.0 to brick.2: rigid, 4 kg") for line in lines), lines)
        self.assertTrue(any(line.startswith("drop: particle_fluid, 4.189 kg, 0.004189 m³,") for line in lines), lines)
        self.assertTrue(any(line.startswith("pond: grid_fluid, 500 kg, 0.5 m³,") for line in lines), lines)
        slip = re.search(r"slip: image_volume, ([\d.e+]+) kg, [\d.e+]+ m³, ([\d.]+) x ", "\n".join(lines))
        self.assertGreater(float(slip[1]), 1e8)     # metres for millimetres
        self.assertAlmostEqual(float(slip[2]), 80, delta=6)

    def test_the_sheet_is_a_picture_of_the_slices(self):
        self.brim("--sheet", "sheet.png")
        width, height, rows = read_png(self.root / "sheet.png")
        self.assertEqual((width, height), (6 * 162 - 2, 4 * 162 - 2))
        middle = rows[1 * 162 + 80][4 * 162 + 80]      # the eleventh of twenty slices
        self.assertGreater(middle, 240)
        self.assertLess(rows[1 * 162 + 2][4 * 162 + 2], 10)

    def test_a_dicom_folder_tells_the_same(self):
        self.write_dicom("1.2.3")
        try:
            out = self.brim("--sheet", "slices.png", file="scans")
        except subprocess.CalledProcessError as error:
            if "built without GDCM" in error.stderr:
                self.skipTest(error.stderr)
            raise
        self.assertIn("DICOM CT, series 1.2.3", out)
        self.assertIn("20 x 20 x 20 voxels of 0.005 x 0.005 x 0.005 m", out)
        self.assertEqual(out.partition("  intensities")[2], self.brim("--sheet", "sheet.png").partition("  intensities")[2]
                         .replace("sheet.png", "slices.png"))
        self.assertEqual((self.root / "slices.png").read_bytes(), (self.root / "sheet.png").read_bytes())
        self.write_dicom("1.2.4")
        with self.assertRaises(subprocess.CalledProcessError) as refused:
            self.brim(file="scans")
        self.assertIn("several series", refused.exception.stderr)
        self.assertIn("1.2.4", refused.exception.stderr)
        self.assertNotIn("\\n", refused.exception.stderr)
        self.assertIn("series 1.2.4", self.brim("--series", "1.2.4", file="scans"))
        (self.root / "scans/1.2.4/IM7").unlink()
        with self.assertRaises(subprocess.CalledProcessError) as refused:
            self.brim("--series", "1.2.4", file="scans")
        self.assertIn("1 missing between", refused.exception.stderr)
        self.assertNotIn("\\n", refused.exception.stderr)


if __name__ == "__main__":
    unittest.main()
