"""The numbers of a supply, as a ``LoadStep`` takes them."""


def line(pressure=0.0, area=0.0, conductance=0.0, exponent=1.0, length=0.0, diameter=0.0):
    """Of a whole actuator."""
    return [pressure, area, conductance, exponent, length, diameter, 1.0]
