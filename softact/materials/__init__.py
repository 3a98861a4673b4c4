"""Laws and material cards.

``LAWS`` maps the name of a law to its class; ``CARDS`` holds the names of the cards;
``load_card`` and ``parse_material`` make a law from what a spec says; ``law.material()`` is what
the solver evaluates. A new law is one file in ``laws/`` and one line here.
"""

from softact.materials.base import CardInfo, Constant, Law, Material
from softact.materials.cards import card_data, card_names, load_card, parse_material
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
CARDS = card_names()

__all__ = [
    "CARDS",
    "LAWS",
    "CardInfo",
    "Constant",
    "Law",
    "Material",
    "card_data",
    "load_card",
    "parse_material",
]
