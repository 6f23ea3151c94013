"""Language models behind OpenAI-compatible endpoints, paid by the token: settings, cache and ledger, client."""


class LLMError(RuntimeError):
    """A language model gave no answer; the message gives the reason and never contains the key."""

    lost = False
    """Whether the endpoint may charge for a request without a complete reply."""


class NoAnswerError(LLMError):
    """The endpoint refuses this request, for example because of its length; it may answer others."""


class SpendingLimitError(LLMError):
    """The spending limit is reached."""
