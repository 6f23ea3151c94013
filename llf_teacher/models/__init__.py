"""Language models behind OpenAI-compatible endpoints, paid by the token: settings, cache and ledger, client."""


class LLMError(RuntimeError):
    """A language model gave no answer; the message says why, and never has the key in it."""


class NoAnswerError(LLMError):
    """The endpoint will not answer this request, as when it is too long or a content filter objects; others it may."""


class SpendingLimitError(LLMError):
    """The spending limit is reached."""
