"""Language models behind OpenAI-compatible endpoints, paid by the token: settings, cache and ledger, client."""


class LLMError(RuntimeError):
    """A language model gave no answer; the message gives the reason and never contains the key."""

    lost = False
    """Whether the endpoint may charge for a request that got no reply, or none that was read to its end."""


class NoAnswerError(LLMError):
    """The endpoint refuses this request, for example because it is too long; it may answer others."""


class SpendingLimitError(LLMError):
    """The spending limit is reached."""
