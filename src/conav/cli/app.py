"""The command and its subcommands. Importing this imports no numerics: help must be quick."""

from cyclopts import App

from conav import __version__
from conav.cli.compare import compare
from conav.cli.execute import execute
from conav.cli.explore import explore
from conav.cli.maps import maps
from conav.cli.plan import plan
from conav.cli.prices import prices
from conav.cli.pursue import pursue
from conav.cli.repair import repair
from conav.cli.reproduce import reproduce
from conav.cli.scenes import scenes
from conav.cli.schema import schema
from conav.cli.task import task
from conav.cli.verify import verify

app = App(
    name="conav",
    help="Multi-robot coordination in unknown 2-D environments: repeatable runs, verified results.",
    version=__version__,
    help_format="plaintext",
)
app.command(explore)
app.command(plan)
app.command(execute)
app.command(prices)
app.command(pursue)
app.command(compare)
app.command(maps)
app.command(scenes)
app.command(task)
app.command(verify)
app.command(repair)
app.command(reproduce)
app.command(schema)
