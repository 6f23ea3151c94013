"""Reads what models and people write, strict in meaning and tolerant in form; it knows worlds and claims, but no seats.

| module | what it reads | entry |
|---|---|---|
| `actions` | a student's text as an action, or a `ParseFailure` | `read_text`, `read_verbatim`, `read_exactly` |
| `questions` | a student's action that may ask the teacher | `read_question` |
| `thoughts` | a model's reply: its reasoning, its answer, invented turns | `split_thought`, `turns_of_others` |
| `answer_formats` | a model's answer in a format that the request asks for | `action_in` |
| `claims` | the sentences of a text as claims, which an oracle can check | `ClaimReader` |
| `phrases` | sentences that are word for word phrases | `Reader`, `read_sentences` |
| `json_values` | JSON within a text, such as a message with claims | `find_message` |

`actions` rests on `answer_place` (labels, sentences, fences) and `action_parsing` (the meaning of a sentence), `claims`
on `claim_building`, `phrases` on `phrase_matching`. Nothing that is read is ever executed.
"""
