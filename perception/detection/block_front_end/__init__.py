"""The paper's own front end: from pictures of one bright block to labelled tracks and outlines."""
