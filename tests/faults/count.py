"""How calls ended, counted by command and by kind of fault, with the stories of what should not be."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

KINDS = (
    "cut",
    "corrupted",
    "empty",
    "huge",
    "hostile",
    "not a number",
    "place",
    "disk full",
    "killed",
    "two at once",
    "environment",
)
COLUMNS = ("tried", "clear error", "accepted", "crash", "blow-up", "half-written")


@dataclass
class Count:
    """Counts by command and kind, and the stories of what should not be."""

    by_command: dict[str, Counter] = field(default_factory=dict)
    by_kind: dict[str, Counter] = field(default_factory=dict)
    stories: list[str] = field(default_factory=list)
    tell: Callable[[str], None] = lambda line: None

    def take(self, command: str, kind: str, label: str, outcome: str, half: Sequence[str], story: str) -> None:
        for counts, key in ((self.by_command, command), (self.by_kind, kind)):
            count = counts.setdefault(key, Counter())
            count["tried"] += 1
            count[outcome] += 1
            count["half-written"] += len(half)
        if half or outcome in ("crash", "blow-up"):
            self.stories.append(f"{command}, {kind}, {label}: {outcome} {' '.join(half)}\n{story}")
            self.tell(self.stories[-1])

    @property
    def bad(self) -> int:
        return sum(c["crash"] + c["blow-up"] + c["half-written"] for c in self.by_kind.values())

    def table(self) -> str:
        lines = []
        for head, counts in (("command", self.by_command), ("kind", self.by_kind)):
            lines += [f"| {head} | " + " | ".join(COLUMNS) + " |", "|---" * (len(COLUMNS) + 1) + "|"]
            rows = [*sorted(counts.items())] if head == "command" else [(k, counts[k]) for k in KINDS if k in counts]
            if head == "kind":
                rows.append(("all", sum(counts.values(), Counter())))
            lines += [f"| {name} | " + " | ".join(str(count[c]) for c in COLUMNS) + " |" for name, count in rows] + [""]
        return "\n".join(lines)
