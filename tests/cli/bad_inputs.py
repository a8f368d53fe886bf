"""What a bad input is: a study, a command line or a call, and what the message about it must say."""


class Asked:
    """A bad input: a study's text, words of a command line (with a study beside them), or a call of Python."""

    def __init__(self, *parts, words="simulate study.toml", study="", call=None):
        self.parts, self.study, self.call = parts, study, call
        self.words = words.split() if isinstance(words, str) else words

    def __repr__(self):
        return f"{self.study} {' '.join(self.words)}" if self.call is None else "Python"


def toml(study, *parts):
    return Asked("study.toml: ", *parts, study=study)


def line(words, *parts, study=""):
    return Asked(*parts, words=words, study=study)


def call(function, *parts):
    return Asked(*parts, call=function)
