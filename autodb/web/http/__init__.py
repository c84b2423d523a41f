"""Requests and answers: who asks, how much, how often, and what is said back."""
