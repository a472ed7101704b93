# facetlog with all extras: docker build -t facetlog . && docker run --rm -v "$PWD:/here" -w /here facetlog recognize photos
FROM debian:12-slim
RUN apt-get update -qq \
    && apt-get install -y -qq --no-install-recommends python3 python3-venv swi-prolog-nox \
    && rm -rf /var/lib/apt/lists/*
COPY . /src
RUN python3 -m venv /opt/facetlog \
    && /opt/facetlog/bin/pip install --quiet --no-cache-dir "/src[all]" \
    && rm -rf /src \
    && /opt/facetlog/bin/facetlog doctor
# Each process of a run takes one thread (src/facetlog/one_thread.py); a writable home is its cache.
ENV HOME=/tmp
ENTRYPOINT ["/opt/facetlog/bin/facetlog"]
