"""serve: the gallery and the studio for browsers."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rumu.cli.options import AsJson
from rumu.cli.terminal import Outcome, print_outcome

if TYPE_CHECKING:
    from rumu.web.server import ServerAddress

OWNER = "The first owner's link (works once)  館主的連結（只能用一次）:"


@print_outcome
def serve(
    *,
    host: Annotated[
        str, typer.Option(help="Address to listen on; beyond this machine only once there is an owner.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port; 0 takes any that is free.")] = 8000,
    database: Annotated[
        str | None,
        typer.Option(help="SQLite file or postgresql:// URL (default: RUMU_DATABASE, else in RUMU_HOME)."),
    ] = None,
    files: Annotated[
        str | None,
        typer.Option(help="Folder or fsspec URL of the files (default: RUMU_FILES, else in RUMU_HOME)."),
    ] = None,
    calibration: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Mark by a calibration that `rumu calibrate` wrote."),
    ] = None,
    processes: Annotated[
        int | None, typer.Option(min=0, help="Processes that mark (default: all cores, at most 4).")
    ] = None,
    root_path: Annotated[
        str,
        typer.Option(
            metavar="PATH",
            envvar="RUMU_ROOT_PATH",
            help="Path on the host under which a reverse proxy shows the service, such as /calligraphy.",
        ),
    ] = "",
    https: Annotated[
        bool,
        typer.Option(
            "--https",
            envvar="RUMU_HTTPS",
            help="Browsers come by HTTPS, even where the proxy sends no X-Forwarded-Proto.",
        ),
    ] = False,
    proxy: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESSES",
            envvar="RUMU_PROXY",
            help="IP addresses or networks of reverse proxies to trust, with commas (default: this machine).",
        ),
    ] = None,
    as_json: AsJson = False,
) -> Outcome:
    """Serve the gallery, the viewer and the studio to browsers until Ctrl-C."""
    from rumu.studio.storage import Storage
    from rumu.web.addresses import check_root_path
    from rumu.web.server import serve as run
    from rumu.web.settings import ServiceSettings

    if calibration is not None:
        from rumu.assessment.calibration import load_calibration

        load_calibration(calibration)  # what is wrong with it is said now
    storage = Storage.chosen(
        database=database, files=files, calibration=calibration and calibration.resolve()
    )
    settings = ServiceSettings(
        storage, processes=processes, root_path=check_root_path(root_path), https=https
    )
    run(
        settings,
        host=host,
        port=port,
        on_listen=lambda address: announce(address, as_json=as_json),
        proxies=proxy,
    )
    raise typer.Exit


def announce(address: ServerAddress, *, as_json: bool = False) -> None:
    """Say where it is, and to whom nobody has opened yet."""
    if as_json:
        facts = {"url": address.url, "owner_link": address.owner_link}
        print(json.dumps(facts), flush=True)
        return
    print(f"rumu: {address.url}  (Ctrl-C ends it)", flush=True)
    if address.owner_link is not None:
        print(f"{OWNER}\n    {address.owner_link}", flush=True)
