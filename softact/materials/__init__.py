"""Laws and material cards.

``LAWS`` maps the name of a law to its class; ``CARDS`` holds the names of the cards;
``load_card`` and ``parse_material`` make a law from what a spec says; ``law.material()`` is what
the solver evaluates. A new law is one file in ``laws/`` and one line in its
``__init__.py``.
"""

from softact.materials.base import CardInfo, Constant, Law, Material
from softact.materials.cards import card_data, card_names, load_card, parse_material
from softact.materials.laws import LAWS

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
