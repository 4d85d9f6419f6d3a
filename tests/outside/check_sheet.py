#!/usr/bin/env python3
"""Asks qpdf whether the sheet of an inspection is sound, and Poppler whether its text has the figures of the report.

usage: check_sheet.py FOLDER
FOLDER has report.json and inspection.pdf of a verified list of points.
Prints one line; exits 1 where qpdf warns, a font is not embedded, or a figure is not in the text.
"""

import json
import pathlib
import subprocess
import sys


def said(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def complaints(folder):
    sheet = folder / "inspection.pdf"
    checked = subprocess.run(["qpdf", "--check", sheet], capture_output=True, text=True, check=False)
    bad = [] if checked.returncode == 0 else [f"qpdf: {checked.stderr.strip()}"]
    fonts = said("pdffonts", sheet).splitlines()[2:]
    # The columns are counted from the right: emb, sub, uni and the object's two numbers.
    bad += [f"font {font}" for font in fonts if font.split()[-5] != "yes"]
    text = said("pdftotext", "-layout", sheet, "-")
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    form = report["measured_form"]
    figures = [f"{form['used']} of {form['points']} points", report["verdict"].upper(), report["profile"]["sha256"]]
    figures += [report["files"][0]["sha256"], f"{form['rest_um']:.3f}"]
    for term in form["terms"]:
        # (Nothing has no sign.)
        figures += [f"{round(term[key], 3) + 0.0:.3f}" for key in ("pv_um", "uncertainty_um")]
    return bad + [f"{figure} is not in the text" for figure in figures if figure not in text]


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[1])
    bad = complaints(folder)
    print(f"sheet: {folder / 'inspection.pdf'}: {'FAILED; ' + '; '.join(bad) if bad else 'ok'}")
    sys.exit(bool(bad))


if __name__ == "__main__":
    main()
