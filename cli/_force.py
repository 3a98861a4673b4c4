"""The option --force: write where something else is."""

import click

force_option = click.option(
    "--force",
    is_flag=True,
    help="Write into DIR even if it holds files that softact did not make there.",
)
force_file_option = click.option(
    "--force", is_flag=True, help="Replace FILE where there is one that softact may not replace."
)
