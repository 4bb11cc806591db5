"""`conav schema`."""

from importlib.resources import files

from conav.errors import InputError

SCHEMAS = {"scene": ("conav.planning", "scene.schema.json")}


def schema(name: str = "scene", /) -> int:
    """Print the JSON schema of a file format, for editors and for checks of your own.

    Parameters
    ----------
    name
        scene (what conav plan reads, as TOML or JSON).
    """
    if name not in SCHEMAS:
        raise InputError(f"schema {name!r}", "is not known", f"known: {', '.join(SCHEMAS)}")
    package, file = SCHEMAS[name]
    print(files(package).joinpath(file).read_text(encoding="utf-8"), end="")
    return 0
