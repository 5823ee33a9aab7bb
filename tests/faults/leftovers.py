"""What calls leave in their folders."""

from pathlib import Path

from hostile import CANARY

from boom_mj.logs import read_mcap


def files(here: Path) -> set[str]:
    """Names of all files and links, relative."""
    return {str(p.relative_to(here)) for p in here.rglob("*") if p.is_symlink() or p.is_file()}


def contents(folder: Path) -> dict[str, bytes]:
    """What every file holds, by relative name."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def half_written(here: Path, before: set[str], done: bool) -> list[str]:
    """Files that a call left and should not have: any new one if it failed, parts and torn ones always."""
    found = []
    for name in sorted(files(here) - before):
        if name.endswith(".part") or (
            not done and not name.startswith("out/") and not name.endswith((".diverged.csv", "seal.sha256", CANARY))
        ):
            found.append(name)
        elif name.endswith(".mcap") and done:
            read_mcap(here / name)
    return found
