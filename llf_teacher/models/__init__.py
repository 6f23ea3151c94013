"""Language models behind OpenAI-compatible endpoints, paid by the token: settings, cache and ledger, client."""


class LLMError(RuntimeError):
    """A language model gave no answer; the message gives the reason and never contains the key."""


class NoAnswerError(LLMError):
    """The endpoint refuses this request, for example because it is too long; it may answer others."""


class SpendingLimitError(LLMError):
    """The spending limit is reached."""
