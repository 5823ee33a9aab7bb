"""What the machine is: the machine file as frozen data, its sections, statics and shape functions."""

from boom_mj.machine.beam import Beam as Beam
from boom_mj.machine.linkages import cylinder_forces as cylinder_forces
from boom_mj.machine.linkages import cylinder_lengths as cylinder_lengths
from boom_mj.machine.model import EffectEntry as EffectEntry
from boom_mj.machine.model import Elastic as Elastic
from boom_mj.machine.model import ElasticLink as ElasticLink
from boom_mj.machine.model import Link as Link
from boom_mj.machine.model import Machine as Machine
from boom_mj.machine.reading import load_machine as load_machine
from boom_mj.machine.reading import load_model as load_model
from boom_mj.machine.reading import machine_file as machine_file
from boom_mj.machine.reading import parse_machine as parse_machine
from boom_mj.machine.reading import with_values as with_values
from boom_mj.machine.rig import Camera as Camera
from boom_mj.machine.rig import Targets as Targets
from boom_mj.machine.shapes import AXES as AXES
from boom_mj.machine.shapes import Shape as Shape
from boom_mj.machine.shapes import ritz_shapes as ritz_shapes
