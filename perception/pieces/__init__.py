"""The solid parts of things: boards, bars and blocks."""
