"""Collecting views: tour, route, driving, pictures, and the record of it all."""
