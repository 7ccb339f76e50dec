# flangeway without Python or a compiler on your machine:
#   docker build -t flangeway .
#   docker run --rm -v "$PWD:/home/flangeway" --user "$(id -u):$(id -g)" flangeway run wheelset
# Results are in out/ of the folder that is mounted. Whoever passes an image on passes Gmsh on: see docs/licences.md.
FROM rust:1-slim-trixie AS wheel
RUN apt-get update && apt-get install -y --no-install-recommends python3-venv && python3 -m venv /tools \
    && /tools/bin/pip install --no-cache-dir 'maturin>=1.9,<2'
COPY . /source
RUN cd /source && /tools/bin/maturin build --release --locked --out /dist \
    && /tools/bin/pip wheel --no-cache-dir --no-deps --wheel-dir /dist ./studies

FROM python:3.13-slim-trixie
# the libraries that Gmsh's wheel expects of the system; Gmsh has no wheel for Linux on arm64, where Debian's is taken: its
# Python (3.13 too) has the module in a folder of its own
RUN apt-get update && apt-get install -y --no-install-recommends \
        libfontconfig1 libgl1 libglu1-mesa libgomp1 libx11-6 libxcursor1 libxext6 libxfixes3 libxft2 libxinerama1 \
        libxrender1 $([ "$(uname -m)" = aarch64 ] && echo python3-gmsh) \
    && if [ "$(uname -m)" = aarch64 ]; then \
        ln -s /usr/lib/python3/dist-packages/gmsh.py "$(python -c 'import site; print(site.getsitepackages()[0])')"; fi \
    && rm -rf /var/lib/apt/lists/* && useradd --create-home flangeway
RUN --mount=type=bind,from=wheel,source=/dist,target=/dist pip install --no-cache-dir /dist/*.whl
# also for a user without a home in the image
ENV FLANGEWAY_CACHE=/tmp/flangeway MPLCONFIGDIR=/tmp/matplotlib
USER flangeway
WORKDIR /home/flangeway
ENTRYPOINT ["flangeway"]
CMD ["run", "wheelset"]
