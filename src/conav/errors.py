"""Errors that a person can act on."""


class InputError(ValueError):
    """Bad input: says where it is, what is wrong and what to do about it, in one line.

    The command line prints it as it is and exits with code 2.
    """

    def __init__(self, place: object, problem: str, remedy: str = "") -> None:
        self.place = str(place)
        self.problem = problem
        self.remedy = remedy
        text = f"{self.place}: {problem}"
        if remedy:
            text += f"; {remedy}"
        super().__init__(" ".join(text.split()))

    def __reduce__(self) -> tuple[type["InputError"], tuple[str, str, str]]:
        return (InputError, (self.place, self.problem, self.remedy))
