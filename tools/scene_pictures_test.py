import importlib.util
import unittest


@unittest.skipUnless(importlib.util.find_spec("PIL"), "no Pillow")
class LighterPictures(unittest.TestCase):
    def test_no_level_is_off_by_more_than_one(self):
        from PIL import Image
        from scene_pictures import lighter

        levels = Image.new("RGB", (256, 1))
        levels.putdata([(level, 255 - level, (7 * level) % 256) for level in range(256)])
        rounded = lighter(levels)
        for before, after in zip(levels.getdata(), rounded.getdata()):
            for a, b in zip(before, after):
                self.assertLessEqual(abs(a - b), 1)
                self.assertEqual(b % 3, 0)


if __name__ == "__main__":
    unittest.main()
