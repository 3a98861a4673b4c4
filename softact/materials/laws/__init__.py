"""One law per file: its constants, its energy as one formula, its source and when to use it.

``LAWS`` maps the name of a law to its class. A new law is one file here and one line below.
"""

from softact.materials.base import Law
from softact.materials.laws.arruda_boyce import ArrudaBoyce
from softact.materials.laws.fung import Fung
from softact.materials.laws.gent import Gent
from softact.materials.laws.holzapfel import Holzapfel
from softact.materials.laws.linear import Linear
from softact.materials.laws.mooney_rivlin import MooneyRivlin
from softact.materials.laws.neo_hookean import NeoHookean
from softact.materials.laws.ogden import Ogden
from softact.materials.laws.reduced_polynomial import ReducedPolynomial
from softact.materials.laws.van_der_waals import VanDerWaals
from softact.materials.laws.yeoh import Yeoh

LAWS: dict[str, type[Law]] = {
    law.model_fields["law"].default: law
    for law in (
        NeoHookean,
        MooneyRivlin,
        Yeoh,
        ReducedPolynomial,
        Ogden,
        ArrudaBoyce,
        VanDerWaals,
        Gent,
        Fung,
        Holzapfel,
        Linear,
    )
}
