"""The option --targets: published requirements beside a run or several."""

import click

targets_option = click.option(
    "--targets",
    multiple=True,
    metavar="NAME",
    help="Say which published requirements of an application the actuator meets: index_finger, "
    "glove, trunk_belt, neck, hip, wrist, ankle, heart, exoskeleton, operation_bending, "
    "operation_linear. May be repeated.",
)
