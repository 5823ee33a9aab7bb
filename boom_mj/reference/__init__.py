"""The paper's Lagrangian model (1)-(28) in numpy and scipy; it never sees MuJoCo."""

from boom_mj.reference.kinematics import JOINTS as JOINTS
from boom_mj.reference.kinematics import coordinate_names as coordinate_names
from boom_mj.reference.model import Modes as Modes
from boom_mj.reference.model import ReferenceModel as ReferenceModel
from boom_mj.reference.model import Simplifications as Simplifications
from boom_mj.reference.motion import ReferenceMotion as ReferenceMotion
from boom_mj.reference.motion import integrate as integrate
