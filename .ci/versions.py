"""Adds what pip would install to the versions that are installed: versions.py KEPT REPORT RELEASE.

KEPT: what `pip freeze` prints, replaced; REPORT: what `pip install --dry-run --report` writes.
"""

import json
import sys
from pathlib import Path

kept, report = (Path(name) for name in sys.argv[1:3])
found = json.loads(report.read_text(encoding="utf-8"))["install"]
more = {f"{item['metadata']['name']}=={item['metadata']['version']}" for item in found}
lines = set(kept.read_text(encoding="utf-8").splitlines()) | more
lines = sorted((x for x in lines if "==" in x and not x.startswith("softact=")), key=str.lower)
head = f"# Versions that passed the tests on {sys.argv[3]}; written by: make constraints"
kept.write_text("\n".join([head, *lines, ""]), encoding="utf-8")
