"""Of logs and what is wrong with them."""

from typing import Any

from boom_mj.cli.documents.part import Number, Part


class LogTopic(Part):
    """One topic of a log."""

    topic: str
    type: str
    encoding: str
    messages: int
    time_base: str
    fields: dict[str, dict[str, Any]]
    findings: list[str]


class LogsInspect(Part):
    """logs inspect LOG --json"""

    log: str
    format: str
    labels: dict[str, str]
    warnings: list[str]
    topics: list[LogTopic]
    map: str
    """The proposed topic map, as TOML."""


class Finding(Part):
    """Something wrong with a log."""

    log: str
    channel: str
    kind: str
    from_s: Number
    to_s: Number
    evidence: str
    action: str
    used: bool
    finding: str
    """All of it in one sentence."""
    repair: str | None
    """What a topic map would have to say."""


class LogsCheck(Part):
    """logs check LOGS... --json FILE"""

    data: list[Finding]
