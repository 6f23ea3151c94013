"""What is made of teachers and studies besides: audits, benchmarks, golden transcripts, tables for documents."""
