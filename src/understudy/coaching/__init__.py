"""The coach: finds what a lesson lacks, where decisions are uncertain, and situations to demonstrate next."""
