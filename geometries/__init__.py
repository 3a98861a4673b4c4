"""The actuators that softact can mesh: one file each, one line each in the registry."""

from softact.geometries.antagonistic import Antagonistic
from softact.geometries.bellows import Bellows
from softact.geometries.bending_tube import BendingTube
from softact.geometries.block import Block
from softact.geometries.braided_muscle import BraidedMuscle
from softact.geometries.fiber_reinforced import FiberReinforced
from softact.geometries.from_mesh import FromMesh
from softact.geometries.from_script import FromScript
from softact.geometries.from_step import FromStep
from softact.geometries.knit_strips import KnitStrips
from softact.geometries.omnidirectional import Omnidirectional
from softact.geometries.pneunet import Pneunet
from softact.geometries.shell_reinforced import ShellReinforced
from softact.geometries.slow_pneunet import SlowPneunet
from softact.geometries.thick_sphere import ThickSphere
from softact.geometries.tube import Tube
from softact.geometries.woven_bending import WovenBending
from softact.geometries.woven_contracting import WovenContracting
from softact.geometries.woven_elongating import WovenElongating
from softact.geometries.woven_stiffening import WovenStiffening

GEOMETRIES = {
    "antagonistic": Antagonistic,
    "bellows": Bellows,
    "bending_tube": BendingTube,
    "block": Block,
    "braided_muscle": BraidedMuscle,
    "fiber_reinforced": FiberReinforced,
    "from_mesh": FromMesh,
    "from_script": FromScript,
    "from_step": FromStep,
    "knit_strips": KnitStrips,
    "omnidirectional": Omnidirectional,
    "pneunet": Pneunet,
    "shell_reinforced": ShellReinforced,
    "slow_pneunet": SlowPneunet,
    "thick_sphere": ThickSphere,
    "tube": Tube,
    "woven_bending": WovenBending,
    "woven_contracting": WovenContracting,
    "woven_elongating": WovenElongating,
    "woven_stiffening": WovenStiffening,
}
