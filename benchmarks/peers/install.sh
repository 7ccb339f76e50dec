#!/bin/sh
# Install programs that the benchmarks compare with: sh benchmarks/peers/install.sh [NAME...]; without a name, all.
# Each gets a folder of its own outside of the repository, ${XDG_CACHE_HOME:-~/.cache}/flangeway-peers/NAME.
set -eu

PYTHON=${PYTHON:-python3.11}
HOME_OF_PEERS=${XDG_CACHE_HOME:-$HOME/.cache}/flangeway-peers
ALL="calculix cvxopt kratos pypolydim scikit-fem sectionproperties"

wheels() { # NAME REQUIREMENT...
    folder=$HOME_OF_PEERS/$1
    shift
    "$PYTHON" -m venv "$folder"
    "$folder/bin/python" -m pip install --quiet --disable-pip-version-check "$@"
}

calculix() { # Debian's package and what it needs, unpacked without touching the system
    command -v apt-get >/dev/null || { echo "calculix is taken from Debian's packages: apt-get is missing" >&2; exit 1; }
    folder=$HOME_OF_PEERS/calculix
    rm -rf "$folder"
    mkdir -p "$folder/packages"
    cd "$folder/packages"
    packages=$(apt-get install --simulate --no-install-recommends --reinstall calculix-ccx | awk '/^Inst/ {print $2}')
    # shellcheck disable=SC2086
    apt-get download -qq $packages
    for package in *.deb; do dpkg -x "$package" ..; done
    cd - >/dev/null
    rm -rf "$folder/packages"
}

for name in ${*:-$ALL}; do
    case $name in
        calculix) calculix ;;
        cvxopt) wheels cvxopt cvxopt==1.3.3 numpy ;;
        kratos)
            wheels kratos numpy KratosMultiphysics==10.4.4 KratosStructuralMechanicsApplication==10.4.4 \
                KratosConstitutiveLawsApplication==10.4.4 KratosLinearSolversApplication==10.4.4 \
                KratosContactStructuralMechanicsApplication==10.4.4
            ;;
        pypolydim) wheels pypolydim pypolydim==4.0.2 numpy scipy ;;
        scikit-fem) wheels scikit-fem scikit-fem==12.0.2 ;;
        sectionproperties) wheels sectionproperties sectionproperties==3.10.2 ;;
        *)
            echo "unknown peer $name; there are: $ALL" >&2
            exit 2
            ;;
    esac
    echo "$name: installed in $HOME_OF_PEERS/$name"
done
