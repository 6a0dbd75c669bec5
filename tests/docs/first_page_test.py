#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""README.md has the form of a first page, and each of its claims is held: see first_page.py and claims.py."""
import os
import re
import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
import claims  # noqa: E402
import first_page  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
HEAD = "| claim | figure | oracle | held by | date |\n|---|---|---|---|---|\n"


class Form(unittest.TestCase):
    def faults(self, text):
        return list(first_page.faults_of(text))

    def test_the_readme_has_it(self):
        self.assertEqual(self.faults(README), [])

    def refused(self, words, text):
        self.assertNotEqual(text, README)
        faults = self.faults(text)
        self.assertTrue(any(words in fault for fault in faults), faults)

    def test_a_page_of_another_form_is_refused(self):
        self.refused("161 lines", README + "\n" * (161 - README.count("\n")))
        self.refused("161 columns", README.replace("## How fast\n", "## How fast\n" + "x" * 161 + "\n"))
        self.refused("the headings are", README.replace("## How fast", "## How quick"))
        fast, sure = (first_page.section(README, heading) for heading in ("## How fast", "## How sure"))
        self.refused("the headings are", README.replace(f"## How fast\n{fast}\n## How sure\n{sure}", f"## How sure\n{sure}\n## How fast\n{fast}"))
        self.refused("the picture", re.sub(r"!\[.*\n", "", README, count=1))
        self.refused("ten lines", README.replace("verdict: ins ok\n", ""))
        self.refused("three commands", re.sub(r"(?m)^binnacle inspect .*\n", "", README))
        self.refused("twenty lines", README.replace('"process": {\n', '"process":\n{' + "\n" * 5))
        self.refused("four rows", re.sub(r"(?m)^\| KITTI .*\n", "", README))
        self.refused("does not say once", README + "Results were known when settings\nwere chosen.\n")


class Claims(unittest.TestCase):
    def test_each_claim_of_the_readme_is_held(self):
        self.assertEqual(list(claims.Checker(ROOT).faults()), [])

    def test_a_row_that_goes_is_missed(self):
        readme = list(claims.sentences(README))
        rows = claims.rows((ROOT / claims.CLAIMS).read_text(encoding="utf-8"))
        self.assertGreater(len(rows), 25)
        for gone in rows:
            missed = list(claims.Checker.uncovered(readme, [row for row in rows if row is not gone]))
            self.assertTrue(missed or not claims.FLAGGED.search(gone["claim"]), gone)

    def faults(self, readme, table):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            (root / "README.md").write_text(f"# Page of 9 words\n\n{readme}\n\n```sh\nall 100 of them\n```\n", encoding="utf-8")
            page = root / claims.CLAIMS
            page.parent.mkdir(parents=True)
            page.write_text("# Claims\n\n| oracle | 5 |\n|---|---|\n\n" + HEAD + table, encoding="utf-8")
            (page.parent / "kept.md").write_text("It took\n**0.471 s** here.\n\n    step     21.5 x\n\n| `row`: of 12 | 12.5 m |\n", encoding="utf-8")
            return list(claims.Checker(root).faults())

    def held(self, readme, table):
        self.assertEqual(self.faults(readme, table), [])

    def refused(self, words, readme, table):
        faults = self.faults(readme, table)
        self.assertTrue(any(words in fault for fault in faults), faults)

    def test_what_is_held(self):
        self.held("It runs `all 7` on x86-64, [here](page-8.md).", "")
        self.held("It takes 3 s.", "| takes 3 s | 3 s | own only | `echo It takes 3 s` | 2026-11-27 |\n")
        self.held("It takes *0.47* s.", "| takes 0.47 s | It took 0.471 s | closed form | `ls`, [kept](kept.md) | 2026-11-27 |\n")
        self.held("| a | b |\n|---|---|\n| 21.5 times | 12.5 m |",
                  "| 21.5 times; 12.5 m | step 21.5 x; row: … 12.5 m | own only | `ls`, [kept](kept.md) | 2026-11-27 |\n")
        self.held("It never fails.", "| never fails | – | own only | [kept](kept.md): here | 2026-11-27 |\n")
        self.held("It never fails.", "| never fails | – | own only | `README.md`: It never fails | 2026-11-27 |\n")

    def test_what_no_row_covers_is_refused(self):
        row = "| takes 3 s | 3 s | own only | `echo It takes 3 s` | 2026-11-27 |\n"
        self.refused("covers '4' in: It takes 3 s and 4 m", "It takes 3 s and 4 m.", row)
        self.refused("covers 'fastest'", "It takes 3 s. It is the fastest.", row)
        self.refused("covers 'Every' in: Every config", "| a | b |\n|---|---|\n| it takes 3 s | Every config |", row)
        self.refused("covers 'ten'", "- It takes 3 s,\n  ten times.", row)
        self.refused("covers '10 820 021'", "It takes 3 s for 10 820 021 inputs.", row)
        self.refused("covers '3'", "It takes 3 s.", "")

    def test_a_row_of_nothing_is_refused(self):
        row = "| takes 3 s | {} | own only | {} | 2026-11-27 |\n"
        self.refused("is not in the README", "It takes time.", row.format("3 s", "`echo 3 s`"))
        self.refused("which is not in what holds it", "It takes 3 s.", row.format("3 s", "`echo 3 m`"))
        self.refused("which is not in what holds it", "It takes 3 s.", row.format("3 s", "`echo 13 s`"))
        self.refused("and its figure has not", "It takes 3 s.", row.format("2.4 s", "`echo 2.4 s`"))
        self.refused("and its figure has not", "It takes 3 s.", row.format("–", "`echo 3 s`"))
        self.refused("fails", "It takes 3 s.", row.format("3 s", "`echo 3 s && false`"))
        self.refused("held by no command", "It takes 3 s.", row.format("3 s", "us"))
        self.refused("no command that is there", "It takes 3 s.", row.format("3 s", "`no_such_command`, [kept](kept.md)"))
        self.refused("nowhere.md is not there", "It takes 3 s.", row.format("3 s", "`ls`, [kept](nowhere.md)"))
        self.refused("has no 'there'", "It takes 3 s.", row.format("–", "[kept](kept.md): there"))
        self.refused("has no 'It runs'", "It takes 3 s.", row.format("–", "`README.md`: It runs"))
        self.refused("gone.cpp is not there", "It takes 3 s.", row.format("–", "`tests/gone.cpp`: It runs"))
        self.refused("has the oracle", "It takes 3 s.", row.replace("own only", "hope").format("3 s", "`echo 3 s`"))
        self.refused("has no date", "It takes 3 s.", row.replace("2026-11-27", "today").format("3 s", "`echo 3 s`"))
        self.refused("a phrase of one word", "It is all 3.", "| all | – | own only | `true` | 2026-11-27 |\n")
        self.refused("held by no command", "It takes 3 s.", "| takes 3 s | 3 s |\n")

    def test_a_page_without_the_table_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "README.md").write_text("It runs.\n", encoding="utf-8")
            page = Path(folder) / claims.CLAIMS
            page.parent.mkdir(parents=True)
            page.write_text("| claim | figure |\n|---|---|\n", encoding="utf-8")
            self.assertRaises(ValueError, lambda: list(claims.Checker(folder).faults()))


if __name__ == "__main__":
    os.environ.setdefault("BINNACLE", "/nonexistent/binnacle")
    unittest.main(verbosity=2)
