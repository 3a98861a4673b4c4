"""How the process in which gmsh runs says things: in lines that begin with a mark."""

from softact.units import one_line

FAULT, NOTE = "softact-fault: ", "softact-note: "


def tell(text: str) -> None:
    """Says something that the user should know, out of the process in which gmsh runs."""
    print(NOTE + one_line(text), flush=True)
