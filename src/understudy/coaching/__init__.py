"""The coach: what a lesson lacks, where a decision is in doubt, and how to set up what is to be shown next."""
