"""Points, planes and poses with their covariance, from what pictures show."""
