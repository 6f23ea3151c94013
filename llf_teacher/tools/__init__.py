"""Tools: audits, benchmarks, films, golden transcripts, and tables and pages for the documents."""
