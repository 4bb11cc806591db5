"""Errors that a person can act on."""


class InputError(ValueError):
    """Bad input: says where it is, what is wrong and what to do about it, in one line.

    `excerpt` follows on lines of its own, as it is: a piece of the input with a mark under the
    place. The command line prints it all and exits with code 2.
    """

    def __init__(self, place: object, problem: str, remedy: str = "", excerpt: str = "") -> None:
        self.place = str(place)
        self.problem = problem
        self.remedy = remedy
        self.excerpt = excerpt
        text = f"{self.place}: {problem}"
        if remedy:
            text += f"; {remedy}"
        text = " ".join(text.split())
        super().__init__(f"{text}\n{excerpt}" if excerpt else text)

    def __reduce__(self) -> tuple[type["InputError"], tuple[str, str, str, str]]:
        return (InputError, (self.place, self.problem, self.remedy, self.excerpt))
