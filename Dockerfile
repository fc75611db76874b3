# One image; docker-compose.yml starts one container of it per process.
FROM python:3.11-slim

# pinocchio's wheel expects the system's OpenMP runtime.
RUN apt-get update \
    && apt-get install -y --no-install-recommends libgomp1 \
    && rm -rf /var/lib/apt/lists/*

WORKDIR /opt/ulna
COPY requirements.lock .
RUN pip install --no-cache-dir --require-hashes -r requirements.lock

# The wheel, not the checkout: what runs here is what was packaged.
COPY pyproject.toml README.md LICENSE ./
COPY services services
COPY hal hal
COPY dforc dforc
COPY firmware_sim firmware_sim
COPY robots robots
RUN pip install --no-cache-dir --no-deps --no-build-isolation . \
    && cd / && python -m services.warm \
    && useradd --create-home ulna

USER ulna
WORKDIR /home/ulna
# Linear algebra on one thread, as the supervisor starts its processes.
ENV PYTHONUNBUFFERED=1 OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1
CMD ["ulna"]
