"""brim info of a volume: histogram, windows that part what is in it, and a picture of its slices. BRIM_PROGRAM names the program."""
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


class Info(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        n = 20
        # Air, a ball of soft tissue in it, a ball of bone in that.
        values = []
        for k in range(n):
            for j in range(n):
                for i in range(n):
                    r = ((i - 9.5) ** 2 + (j - 9.5) ** 2 + (k - 9.5) ** 2) ** 0.5
                    values.append((1200 if r < 4 else 40 if r < 8 else -1000) + (7 * i + 3 * j + k) % 11 - 5)
        (self.root / "head.nrrd").write_bytes(b"NRRD0004\ntype: short\ndimension: 3\nsizes: 20 20 20\nspacings: 5 5 5\n"
                                              b"endian: little\nencoding: raw\n\n" + struct.pack(f"<{n**3}h", *values))

    def brim(self, *words):
        return subprocess.run([BRIM, "info", "head.nrrd", *words], capture_output=True, text=True, cwd=self.root, check=True).stdout

    def test_windows_part_what_is_in_the_volume(self):
        out = self.brim()
        windows = [tuple(map(float, m)) for m in re.findall(r"window \[([-\d.e+]+), ([-\d.e+]+)\]", out)]
        self.assertEqual(len(windows), 2, out)
        self.assertTrue(-990 < windows[0][0] < windows[0][1] < 30, out)
        self.assertTrue(50 < windows[1][0] < windows[1][1] < 1190, out)
        self.assertIn("Hounsfield", out)
        shares = [float(m) for m in re.findall(r"# +([\d.e+-]+) %", out)]
        self.assertAlmostEqual(sum(shares), 100, delta=2)

    def test_the_sheet_is_a_picture_of_the_slices(self):
        self.brim("--sheet", "sheet.png")
        width, height, rows = read_png(self.root / "sheet.png")
        self.assertEqual((width, height), (6 * 162 - 2, 4 * 162 - 2))
        middle = rows[1 * 162 + 80][4 * 162 + 80]      # the eleventh of twenty slices
        self.assertGreater(middle, 240)
        self.assertLess(rows[1 * 162 + 2][4 * 162 + 2], 10)


if __name__ == "__main__":
    unittest.main()
