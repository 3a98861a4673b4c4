"""What stands about softact in more than one file says the same everywhere."""

import tomllib
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def test_the_citation_has_the_version_and_licence_of_the_project():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["version"] == PROJECT["version"]
    assert citation["license"] == PROJECT["license"]["text"]


def test_the_citation_names_those_who_hold_the_copyright():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    holder = next(line for line in (ROOT / "LICENSE").read_text().splitlines() if "(c)" in line)
    assert [author["name"] for author in citation["authors"]] == [holder.split(maxsplit=3)[3]]


def test_the_changelog_has_the_version_that_comes_next():
    text = (ROOT / "CHANGELOG.md").read_text()
    assert f"## [{PROJECT['version']}]" in text or f"will be {PROJECT['version']}" in text


def test_hooks_download_nothing():
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())
    assert [repo["repo"] for repo in hooks["repos"]] == ["local"]
    for hook in hooks["repos"][0]["hooks"]:
        assert hook["language"] == "system"
        assert hook["entry"].startswith(".venv/bin/")
