"""Python interface: the names that `facetlog` itself exports.

Steps and warnings are logged under the logger `facetlog`; nothing is shown unless the program that
uses it says so.
"""

import logging

logging.getLogger("facetlog").addHandler(logging.NullHandler())
