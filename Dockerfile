# docker build -t recurse . && docker run --rm -v "$PWD:/work" recurse render scene.pbrt -o picture.png
FROM debian:bookworm AS build
COPY . /source
WORKDIR /source
RUN bash -c 'source scripts/lib.sh && requirePackages "${BUILD_PACKAGES[@]}" file dpkg-dev && \
    configure portable -DBUILD_TESTING=OFF -DRECURSE_BENCHMARKS=OFF && build portable && cd build/portable && cpack'
FROM debian:bookworm-slim
RUN --mount=from=build,source=/source/build/portable,target=/packages \
    apt-get update && apt-get install -y --no-install-recommends /packages/recurse_*.deb && rm -rf /var/lib/apt/lists/*
WORKDIR /work
ENTRYPOINT ["recurse"]
