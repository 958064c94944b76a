"""Elastic beams, discretised along their length: what a flexible body is made of. One file per formulation."""
