"""The blind check: cases whose effect is sealed, their diagnosis by processes that cannot know it, and the score.

`generate` draws and simulates on a plant that is not the diagnosing model, `run` diagnoses, `figures` opens the seal,
`oracle` says of misses whether the search or the model is to blame.
"""

from boom_mj.engine import mujoco as _mujoco  # noqa: F401  # isort: skip


from boom_mj.blind.answers import answer_schema as answer_schema
from boom_mj.blind.answers import read_answer as read_answer
from boom_mj.blind.boom_bench import SHORT as SHORT
from boom_mj.blind.boom_bench import SUITE as SUITE
from boom_mj.blind.boom_bench import BoomBench as BoomBench
from boom_mj.blind.boom_bench import Suite as Suite
from boom_mj.blind.figures import Score as Score
from boom_mj.blind.figures import pooled as pooled
from boom_mj.blind.figures import score as score
from boom_mj.blind.generate import make_cases as make_cases
from boom_mj.blind.leaderboard import leaderboard as leaderboard
from boom_mj.blind.leaderboard import leaderboard_row as leaderboard_row
from boom_mj.blind.mjcf_bench import MjcfBench as MjcfBench
from boom_mj.blind.oracle import with_hindsight as with_hindsight
from boom_mj.blind.page import html_page as html_page
from boom_mj.blind.page import markdown_page as markdown_page
from boom_mj.blind.pictures import confusion_svg as confusion_svg
from boom_mj.blind.pictures import reliability_svg as reliability_svg
from boom_mj.blind.run import answer_cases as answer_cases
from boom_mj.blind.run import waiting_cases as waiting_cases
from boom_mj.blind.sampling import MIX as MIX
