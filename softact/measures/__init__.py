"""Numbers per equilibrium: one measure a file, each a function from a snapshot to CSV columns.

A new measure is one file with a ``Measure`` and one line in ``MEASURES``.
"""

from softact.measures.air import AIR
from softact.measures.base import Measure
from softact.measures.bending import BENDING
from softact.measures.contact import CONTACT
from softact.measures.elongation import ELONGATION
from softact.measures.energy import ENERGY
from softact.measures.faces import FACES
from softact.measures.failure import FAILURE
from softact.measures.fibres import FIBRES
from softact.measures.held_tip import HELD_TIP
from softact.measures.lateral import LATERAL
from softact.measures.longer_waves import LONGER_WAVES
from softact.measures.mass import MASS
from softact.measures.module import MODULE
from softact.measures.module_stiffness import MODULE_STIFFNESS
from softact.measures.pressure import PRESSURE
from softact.measures.probe import PROBE_STRESS, PROBES
from softact.measures.radial_growth import RADIAL_GROWTH
from softact.measures.reaction import REACTION
from softact.measures.strain import STRAIN
from softact.measures.stress import STRESS
from softact.measures.target_line import TARGET_LINE
from softact.measures.tip import TIP
from softact.measures.twist import TWIST
from softact.measures.volume import VOLUME

MEASURES: dict[str, Measure] = {
    measure.name: measure
    for measure in (
        PRESSURE,
        BENDING,
        TIP,
        TARGET_LINE,
        PROBES,
        PROBE_STRESS,
        FACES,
        ELONGATION,
        LATERAL,
        RADIAL_GROWTH,
        TWIST,
        MODULE,
        MODULE_STIFFNESS,
        LONGER_WAVES,
        VOLUME,
        AIR,
        REACTION,
        HELD_TIP,
        CONTACT,
        STRESS,
        STRAIN,
        FAILURE,
        FIBRES,
        ENERGY,
        MASS,
    )
}

__all__ = ["MEASURES", "Measure"]
