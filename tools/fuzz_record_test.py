import tempfile
import unittest
from pathlib import Path

import fuzz_record

WHOLE = "#2 INITED cov: 10\n#4096 pulse cov: 12\nDone 5000 runs in 2 second(s)\nstat::number_of_executed_units: 5000\n"
CUT = "#2 INITED cov: 10\n#4096 pulse cov: 12\n#8192 pulse cov: 12\n"
FOUND = "#100 NEW cov: 3\n==7== ERROR: AddressSanitizer: heap-buffer-overflow\nSUMMARY: AddressSanitizer: x\nstat::number_of_executed_units: 120\n"


class FuzzRecord(unittest.TestCase):
    def test_executions_are_those_of_the_log_whether_it_ended_was_cut_or_found_something(self):
        self.assertEqual(fuzz_record.executions(WHOLE), (5000, 0))
        self.assertEqual(fuzz_record.executions(CUT), (8192, 0))
        self.assertEqual(fuzz_record.executions(FOUND), (120, 1))
        self.assertEqual(fuzz_record.executions(""), (0, 0))

    def test_totals_are_the_sums_of_what_was_added(self):
        with tempfile.TemporaryDirectory() as folder:
            record = Path(folder) / "executions.tsv"
            for target, log in (("ply", WHOLE), ("off", CUT), ("ply", FOUND)):
                fuzz_record.add(record, target, log, 2, "abc")
            sums = fuzz_record.totals(record)
            self.assertEqual(sums, {"ply": (5120, 1), "off": (8192, 0)})
            text = fuzz_record.report(sums, ["off", "ply", "stl"])
        self.assertIn("13,312 executions of 10,000,000", text)
        self.assertIn("1 with a finding", text)
        self.assertEqual(text.count("fewer than"), 3, text)


if __name__ == "__main__":
    unittest.main()
