"""name=value on the command line."""

from conav.errors import InputError


def parse_settings(pairs: list[str]) -> dict[str, str]:
    """The settings of several `--set name=value`.

    >>> parse_settings(["keep-goal=yes"])
    {'keep_goal': 'yes'}
    """
    settings: dict[str, str] = {}
    for pair in pairs:
        name, equals, value = pair.partition("=")
        if not equals or not name:
            raise InputError(f"--set {pair}", "is not name=value", "write --set name=value")
        settings[name.strip().replace("-", "_")] = value.strip()
    return settings
