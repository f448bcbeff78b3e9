# haptable - soft objects that a haptic device can touch at 1 kHz.
# The Makefile is the architecture: every arrow is a file, and data flows one way:
#
#   scene + mesh -> precompute -> tables -> codegen -> C -> servo <- LCM -> device, viewer
#
# `make help` lists what can be made.

BUILD ?= build
# Files' names may hold anything. make expands nothing in those that people give, and a recipe has them as
# "$$HAPTABLE_SCENE"; BUILD, TARGET and NAME stand in rules too, and hold nothing that make or a shell reads otherwise.
as_given = $(eval unexport $(1))$(eval export HAPTABLE_$(1) := $$(value $(1)))
letters = a b c d e f g h i j k l m n o p q r s t u v w x y z A B C D E F G H I J K L M N O P Q R S T U V W X Y Z \
    0 1 2 3 4 5 6 7 8 9 . _ - + @ / ~ ,
without = $(if $(2),$(call without,$(subst $(firstword $(2)),,$(1)),$(wordlist 2,99,$(2))),$(1))
plain = $(if $(call without,$(value $(1)),$(letters)),$(error $(1)=$(value $(1)): give letters, digits and . _ - + @ / ~ ,),$(value $(1)))
override BUILD := $(call plain,BUILD)
# One name a folder, from here where it lies here: dependencies are read by the names that they were written with.
override BUILD := $(patsubst $(CURDIR)/%,%,$(abspath $(BUILD)))
override NAME := $(call plain,NAME)
SCENE ?= meshes/cube.toml
$(call as_given,SCENE)

# Debian's, which has the packages of scripts/setup.sh's set lab; another one needs lab/requirements.txt.
LAB_PYTHON ?= /usr/bin/python3
LAB = env BUILD=$(BUILD) $(LAB_PYTHON) -m lab

CC = gcc
CXX = g++
# Warnings are errors under the compiler that we use, without those of its optimiser: whether it gives these depends on
# what was inlined. Another compiler's new warnings are warnings.
OF_OPTIMISER = array-bounds dangling-pointer free-nonheap-object maybe-uninitialized nonnull restrict stringop-overflow stringop-overread
OURS := $(filter 12.%,$(shell $(CXX) -dumpfullversion 2>/dev/null))
ifeq ($(origin WERROR),undefined)
WERROR := $(if $(OURS),-Werror $(addprefix -Wno-error=,$(OF_OPTIMISER)))
endif
# It collects its garbage from a gigabyte on: an eighth of its time, for a fifth more memory (at most 1.7 GB a job).
COLLECT = $(if $(OURS),--param ggc-min-heapsize=1000000 --param ggc-min-expand=200)
OPT ?= -O2
INCLUDE = -I. -I$(BUILD) -I$(BUILD)/lcm -isystem /usr/include/eigen3 -isystem /usr/include/suitesparse -isystem /usr/include/cairo
CXX_WARN = -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wnon-virtual-dtor $(WERROR)
C_WARN = -pedantic -Wall -Wextra -Wshadow -Wconversion -Wdouble-promotion -Wstrict-prototypes -Wmissing-prototypes $(WERROR)
# -ffp-contract=off: the same bits on every processor, with and without fused multiply-add.
FP = -ffp-contract=off
# gcc 12's SLP vectoriser drops the rounding of double(float(x)) (seen in a test that compared with the servo).
NO_SLP = -fno-tree-slp-vectorize
CXXFLAGS = -std=c++20 $(OPT) $(FP) $(NO_SLP) $(COLLECT) $(CXX_WARN) $(INCLUDE) $(EXTRA_FLAGS) -MMD -MP
CFLAGS = -std=c99 -ffreestanding $(OPT) $(FP) $(C_WARN) -I. -Ifirmware $(EXTRA_FLAGS) -MMD -MP
LDFLAGS = $(EXTRA_FLAGS)

# What most files include is read once, which saves a third of the compiler's time. A compiler cache does not see
# through it: then it is left out (make PRECOMPILED= leaves it out too).
ifeq ($(origin PRECOMPILED),undefined)
PRECOMPILED := $(if $(findstring ccache,$(CXX) $(shell readlink -f "$$(command -v $(firstword $(CXX)))")),,yes)
endif
precompiled = $(if $(PRECOMPILED),$(BUILD)/host/precompiled.hpp.gch)
COMPILE = $(CXX) $(CXXFLAGS) $(if $(precompiled),-include $(precompiled:.gch=))

.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
.SUFFIXES:
MAKEFLAGS += --no-builtin-rules
# As many jobs as there are processors, unless -j says otherwise.
ifeq ($(MAKELEVEL)$(filter -j%,$(MAKEFLAGS)),0)
MAKEFLAGS += -j$(shell nproc)
endif

# ---- units: files of a folder are compiled together, as many as have 1400 lines --------------------------------------
# The compiler reads their headers and makes their templates once; names of their unnamed namespaces are one folder's.

# But not those of other options than their folder's, nor those that are linked without it.
ALONE = $(addprefix host/,view/deformation.cpp view/antialias.cpp view/offscreen.cpp strokes/solid.cpp) \
    $(addprefix host/,fem/hooke.cpp fem/elasticity.cpp mesh/quadratic_tet.cpp link/finger_path.cpp bench/subject.cpp)
HOST_FILES := $(shell find host codegen -name '*.cpp' -not -path '*/mpi/*' -not -path '*/examples/*')
TEST_FILES := $(shell find tests -name '*.cpp' -not -path 'tests/fuzz/*' -not -path 'tests/soak/*' -not -path 'tests/host/mpi/ranks/*')
UNITED := $(filter-out %/main.cpp host/mesh/cgal/% host/mesh/gmsh/% $(ALONE),$(HOST_FILES)) $(TEST_FILES)
# What the library holds, besides the firmware: files of its own options (packaging/install.mk) in units of their own.
LIBRARY_CXX := $(wildcard host/library/*.cpp host/tables/*.cpp) $(addprefix host/base/,file.cpp hash.cpp json.cpp limits.cpp scene_options.cpp stiffening.cpp summary_lines.cpp) \
    host/session/energy.cpp $(filter-out $(addprefix codegen/,main.cpp text.cpp display.cpp),$(wildcard codegen/*.cpp))
write_units = { sh scripts/units.sh $(1) 1400 $(BUILD)/units/ $(filter-out $(LIBRARY_CXX),$(UNITED)); sh scripts/units.sh $(1) 1400 $(BUILD)/units/library/ $(LIBRARY_CXX); }
UNITS := $(shell $(write_units))
# The largest are not the last ones, for which one processor would wait.
tests = $(filter $(BUILD)/units/tests%,$(UNITS:%=%.o))
TESTS = $(filter-out $(BUILD)/units/tests-host%,$(tests)) $(filter $(BUILD)/units/tests-host%,$(tests))
TEST_OBJECTS = $(TESTS) $(TEST_FILES:%=$(BUILD)/%.o)

# ---- parts: one small library a folder; its main.cpp, where it has one, beside it ----------------------------------

objects = $(patsubst %,%.o,$(foreach pool,units units/library,$(filter $(BUILD)/$(pool)/$(subst /,-,$(1)).%,$(UNITS)))) \
    $(patsubst %,$(BUILD)/%.o,$(filter-out %/main.cpp $(UNITED),$(wildcard $(1)/*.cpp $(1)/*.c)))

BASE       = $(call objects,host/base)
TABLES     = $(call objects,host/tables) $(BASE)
DENSE      = $(call objects,host/dense)
SCENES     = $(call objects,host/scene) $(DENSE) $(BASE)
MESH       = $(call objects,host/mesh) $(BASE)
FEM        = $(call objects,host/fem) $(BASE)
FIRMWARE   = $(call objects,firmware)
SOLVE      = $(call objects,host/inverse/solve)
CODEGEN    = $(call objects,codegen) $(TABLES) $(FIRMWARE)
INVERSE    = $(call objects,host/inverse) $(SOLVE) $(DENSE) $(BASE)
BODY       = $(call objects,host/body) $(INVERSE) $(SCENES) $(MESH) $(FEM)
COMPLIANCE = $(call objects,host/compliance) $(BODY) $(CODEGEN)
PRECOMPUTE = $(call objects,host/precompute) $(COMPLIANCE)
LINK       = $(call objects,host/link) $(BASE)
SESSION    = $(call objects,host/session) $(LINK) $(FIRMWARE)
SERVO      = $(call objects,host/session/servo) $(SESSION)
BRIDGE     = $(call objects,host/session/bridge) $(SESSION) $(CODEGEN)
DEVICE     = $(call objects,host/device) $(LINK) $(SCENES) $(TABLES)
RUN        = $(call objects,host/run) $(LINK) $(SCENES)
FIT        = $(call objects,host/fit) $(SERVO) $(SCENES) $(CODEGEN)
ELEMENTS   = $(addprefix $(BUILD)/host/,fem/hooke.cpp.o fem/elasticity.cpp.o mesh/quadratic_tet.cpp.o)
VIEW       = $(call objects,host/page) $(call objects,host/view) $(ELEMENTS) $(SOLVE) $(LINK) $(CODEGEN)
LIVE       = $(call objects,host/page/live) $(VIEW) $(DEVICE)
MPI        = $(call objects,host/inverse/mpi) $(PRECOMPUTE)
TARGETED   = $(call objects,host/target) $(CODEGEN)
STROKES    = $(call objects,host/strokes) $(BUILD)/host/link/finger_path.cpp.o $(PRECOMPUTE)
BENCH      = $(call objects,host/bench) $(VIEW) $(FIRMWARE) $(PRECOMPUTE)

LIBS_BASE       = -lfmt -lxxhash
LIBS_PRECOMPUTE = -lcholmod -larpack -lopenblas -lpugixml -lz $(LIBS_BASE)
LIBS_STROKES    = $(LIBS_PRECOMPUTE) -lgmp -lmpfr
LIBS_MPI        = $(LIBS_PRECOMPUTE) -ldmumps -lmumps_common $(shell mpicxx --showme:link)
LIBS_LINK       = -llcm $(LIBS_BASE)
LIBS_DEVICE     = -lwebsockets $(LIBS_LINK)
LIBS_VIEW       = -lOSMesa -lcairo -lpng -lz -lopenblas $(LIBS_LINK)

# What reads meshes by Gmsh and CGAL is loaded where a mesh asks for it, from lib/ beside the program's folder.
MODULES = $(BUILD)/lib/haptable-cgal.so $(BUILD)/lib/haptable-gmsh.so
IN_MODULES = $(patsubst %,$(BUILD)/%.o,$(wildcard host/mesh/*/*.cpp))

# Equation 8 is a long product: it wants the widest instructions that this machine has (NATIVE=: those that all have).
NATIVE ?= -march=native
$(BUILD)/host/view/deformation.cpp.o: private OPT = -O3 $(NATIVE)
# The servo on this machine: the same bits, and less time (docs/design/speed.md).
$(BUILD)/firmware/%.c.o: private OPT = -O3
# What goes over every pixel.
$(BUILD)/host/view/antialias.cpp.o $(BUILD)/host/view/offscreen.cpp.o: private OPT = -O3

# An example includes the installed header by its name.
$(BUILD)/tidy/UnifiedSource-host-library-examples.%.ok: private INCLUDE += -Ihost/library
# Not -I: MPI's headers are not ours to warn about.
$(BUILD)/host/precompute/mpi/%.cpp.o $(BUILD)/host/inverse/mpi/%.cpp.o $(BUILD)/tests/host/mpi/ranks/%.cpp.o $(BUILD)/tidy/UnifiedSource-host-inverse-mpi%.ok $(BUILD)/tidy/UnifiedSource-host-precompute-mpi%.ok: private INCLUDE += $(patsubst %,-isystem %,$(shell mpicxx --showme:incdirs)) -DOMPI_SKIP_MPICXX

# CGAL's exact predicates count on directed rounding.
$(BUILD)/host/mesh/cgal/%.cpp.o: private FP += -frounding-math
$(BUILD)/host/strokes/solid.cpp.o: private FP += -frounding-math
$(IN_MODULES): private CXXFLAGS += -fPIC

# Of other flags than what was precompiled.
$(BUILD)/host/view/deformation.cpp.o $(BUILD)/host/strokes/solid.cpp.o $(IN_MODULES): private precompiled =

# A unit includes files: it, too, is the only one that has their unnamed namespaces' types.
$(filter-out $(TESTS),$(UNITS:%=%.o)): private CXX_WARN += -Wno-subobject-linkage

TYPES = $(patsubst codegen/lcm/%.lcm,$(BUILD)/lcm/haptable/%.hpp,$(wildcard codegen/lcm/*.lcm)) $(BUILD)/lcm/haptable/channels.hpp
.SECONDARY: $(TYPES) $(BUILD)/host/precompiled.hpp.gch $(BUILD)/tests/precompiled.hpp.gch
PROGRAMS = $(addprefix $(BUILD)/bin/,haptable-precompute haptable-codegen haptable-device haptable-view haptable-bridge haptable-run haptable-count haptable-fit)

# ---- for people ----------------------------------------------------------------------------------------------------

# What every page is made of: the servo for a browser, the page's own text, and three.js.
PAGE_TEXT = $(patsubst host/page/web/%,$(BUILD)/lib/page/%,$(wildcard host/page/web/*))
PAGE_PARTS = $(BUILD)/lib/page/servo.wasm $(BUILD)/lib/page/three.min.js $(PAGE_TEXT)

# all: every host program (the default)
.PHONY: all
all: $(MODULES) $(PROGRAMS)

# demo: install what is missing, build, touch the cube over LCM for a few seconds, draw it, make the page that touches the mouse
.PHONY: demo
demo: $(addprefix $(BUILD)/bin/,haptable-precompute haptable-device haptable-run haptable-view) $(BUILD)/lib/haptable-gmsh.so $(SERVO) $(PAGE_PARTS)
	@$(MAKE) --no-print-directory scene-alone SCENE=meshes/cube.toml
	@$(MAKE) --no-print-directory scene-alone SCENE=meshes/mouse.toml
	@BUILD=$(BUILD) sh scripts/demo.sh
	@$(MAKE) --no-print-directory touch SCENE=meshes/mouse.toml

# demo-tried: make demo in a clone in a Debian 12 that has git and make and nothing else
.PHONY: demo-tried
demo-tried: | $(BUILD)/setup-bare.stamp
	@sh scripts/bare.sh 'make demo'

# touch: one page that lets a pointer touch a scene's body, in any browser (make touch SCENE=meshes/mouse.toml)
.PHONY: touch
touch: $(BUILD)/bin/haptable-precompute $(BUILD)/bin/haptable-view $(PAGE_PARTS) $(BUILD)/lib/haptable-gmsh.so
	@$(MAKE) --no-print-directory scene-alone SCENE_MAKES=
	@name=$$($(BUILD)/bin/haptable-precompute --print-name -- "$$HAPTABLE_SCENE") && \
	$(BUILD)/bin/haptable-view $(BUILD)/$$name --page $(BUILD)/$$name/touch.html --quiet && \
	echo "$(BUILD)/$$name/touch.html: open it in a browser, and press on the body"

# test: install what is missing, build and run every test but those of packages, of the laboratory and of several machines
.PHONY: test
test: test-python $(MODULES) $(BUILD)/tests/unit $(BUILD)/bin/haptable-keys all $(PAGE_PARTS) library
	@$(MAKE) --no-print-directory images
	@BUILD=$(BUILD) sh scripts/test.sh

# test-changed: build the tests and run those beside the sources that changed since this was last green
.PHONY: test-changed
test-changed: $(BUILD)/tests/unit
	@BUILD=$(BUILD) sh scripts/test-changed.sh

# test-all: make test, then what proves packages, installed copies, the laboratory and several machines; and three seconds of fuzz
.PHONY: test-all
test-all: test
	@$(MAKE) --no-print-directory test-fuzz test-mpi test-lab test-packages
	@BUILD=$(BUILD) sh scripts/test.sh whole

# test-tried: make test in a clone in a Debian 12 that has git and make and nothing else
.PHONY: test-tried
test-tried: | $(BUILD)/setup-bare.stamp
	@sh scripts/bare.sh 'make test'

# What the tests run besides, side by side: none makes what another does.
.PHONY: test-fuzz test-mpi test-lab test-packages test-python
test-fuzz: $(TYPES)
	@BUILD=$(BUILD) sh scripts/fuzz.sh 3

# lab: what lab/ compares with that Debian does not have (lab/references.txt)
.PHONY: lab
lab: $(BUILD)/lab/site/ready
$(BUILD)/lab/site/ready: lab/references.txt | $(BUILD)/setup-lab.stamp
	@$(LAB_PYTHON) -m venv $(BUILD)/lab/venv && \
	$(BUILD)/lab/venv/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --upgrade --target $(@D) -r $< && \
	touch $@ || { echo "lab: pip could not install $< (does this machine reach pypi.org?)" >&2; exit 1; }

test-mpi:
	@if sh scripts/setup.sh mpi; then $(MAKE) --no-print-directory mpi $(BUILD)/tests/ranks; else echo "no Open MPI or MUMPS: the tests of mpi skip"; fi
test-lab: $(addprefix $(BUILD)/bin/haptable-,contact $(addprefix bench-,ticks devices inversion realtime)) $(BUILD)/setup-lab.stamp
	@$(MAKE) --no-print-directory $(BUILD)/lab/site/ready || echo "no packages of PyPI: the tests beside scikit-fem skip"
test-packages: $(BUILD)/setup-package.stamp
	@$(MAKE) --no-print-directory $(BUILD)/python/wheels/ready || echo "no packages of PyPI: the tests that install them skip"
test-python: | $(BUILD)/setup-test.stamp
	@$(MAKE) --no-print-directory $(BUILD)/python/ready || echo "no packages of PyPI: the tests that speak with Python clients skip"

# test-kernels: tables of ten scenes and the numerical tests under every OpenBLAS kernel that this processor can run, with 1 and 2 threads
.PHONY: test-kernels
test-kernels: $(MODULES) $(BUILD)/tests/unit $(BUILD)/bin/haptable-precompute
	@if sh scripts/setup.sh mpi; then $(MAKE) --no-print-directory mpi; fi
	@BUILD=$(BUILD) sh scripts/test-kernels.sh $(KERNELS)

# test-tables: the part of test-kernels that compares the tables' hashes, a minute
.PHONY: test-tables
test-tables: $(MODULES) $(BUILD)/bin/haptable-precompute
	@BUILD=$(BUILD) ONLY=tables sh scripts/test-kernels.sh $(KERNELS)

# fuzz: the readers that we wrote, the scene file and LCM's messages under libFuzzer, ten minutes each (make fuzz SECONDS=600)
SECONDS ?= 600
.PHONY: fuzz
fuzz: $(BUILD)/setup.stamp $(BUILD)/setup-test.stamp $(TYPES)
	@BUILD=$(BUILD) sh scripts/fuzz.sh $(SECONDS)

# sanitize: every mesh of ../shared, sound and broken, under Address- and UndefinedBehaviorSanitizer
.PHONY: sanitize
sanitize: $(BUILD)/setup.stamp $(BUILD)/setup-surface.stamp
	@$(MAKE) --no-print-directory BUILD=$(BUILD)/sanitize OPT=-O1 EXTRA_FLAGS="-fsanitize=address,undefined -g1" WERROR= \
	$(addprefix $(BUILD)/sanitize/,bin/haptable-precompute lib/haptable-cgal.so lib/haptable-gmsh.so)
	@BUILD=$(BUILD) sh scripts/sanitize.sh ../shared/meshes ../shared/meshes/bad

# soak: an hour of simulated time with faults by lot, watched, under the same sanitizers (SOAK_SECONDS=3600 SEED=1)
SOAK_SECONDS ?= 3600
.PHONY: soak
soak: $(BUILD)/setup.stamp $(BUILD)/setup-test.stamp
	@$(MAKE) --no-print-directory BUILD=$(BUILD)/sanitize OPT=-O1 EXTRA_FLAGS="-fsanitize=address,undefined -g1" WERROR= $(BUILD)/sanitize/tests/soak/soak
	@UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 $(BUILD)/sanitize/tests/soak/soak --seconds $(SOAK_SECONDS) --seed $(SEED)

# bench-realtime: the loop in real time beside one with a servo that does nothing, quiet and under load, into docs/LOOP.md: four minutes with nothing else on the machine (REALTIME_SECONDS=60)
REALTIME_SECONDS ?= 60
.PHONY: bench-realtime
bench-realtime: $(addprefix $(BUILD)/bin/,haptable-bench-realtime haptable-precompute haptable-device) $(BUILD)/setup-lab.stamp
	@$(MAKE) --no-print-directory scene-alone SCENE=meshes/cube.toml
	@mkdir -p $(BUILD)/realtime
	@sh scripts/loopback.sh $(LAB) realtime meshes/cube.toml --seconds $(REALTIME_SECONDS) $(BUILD)/realtime/realtime.json
	@rm -f $(BUILD)/report/realtime.json
	@$(LAB) take $(BUILD)/realtime docs/LOOP.md docs/data/realtime.csv

# scene: precompute one scene and build its servo: build/<name>/... (make scene SCENE=meshes/cube.toml)
.PHONY: scene
scene: all
	@$(MAKE) --no-print-directory scene-alone

# The same, without the programs that it does not run; what is made of the scene besides its tables. What of them is
# still true haptable-precompute knows best.
SCENE_MAKES ?= servo
.PHONY: scene-alone
scene-alone: $(BUILD)/bin/haptable-precompute
	@[ -n "$$HAPTABLE_SCENE" ] || { echo "make: name a scene, as in make scene SCENE=meshes/cube.toml" >&2; exit 1; }
	@name=$$($(BUILD)/bin/haptable-precompute --print-name -- "$$HAPTABLE_SCENE") && \
	$(BUILD)/bin/haptable-precompute --build $(BUILD) -- "$$HAPTABLE_SCENE" && \
	{ [ -z "$(SCENE_MAKES)" ] || $(MAKE) --no-print-directory $(BUILD)/$$name/$(SCENE_MAKES) NAME=$$name; }

# mpi: haptable-precompute for several machines, with Open MPI and MUMPS
.PHONY: mpi
mpi:
	@sh scripts/setup.sh mpi
	@$(MAKE) --no-print-directory $(MODULES) $(BUILD)/bin/haptable-precompute-mpi

# strokes: a million random strokes over every mesh, judged by geometry not the servo's (SEED=1 COUNT=1000000; then: make report)
STROKES_OVER = meshes meshes/hard $(wildcard ../shared/meshes ../shared/contact)
SEED ?= 1
COUNT ?= 1000000
.PHONY: strokes
strokes: $(MODULES) $(BUILD)/bin/haptable-strokes $(BUILD)/setup-lab.stamp
	@mkdir -p $(BUILD)/report
	@$(BUILD)/bin/haptable-strokes $(STROKES_OVER) --seed $(SEED) --strokes $(COUNT) --build $(BUILD)/strokes -o $(BUILD)/strokes.json
	@$(LAB) strokes $(BUILD)/strokes.json $(BUILD)/report/strokes.json

# bench: measure speed and error into every page and build/report/index.html, beside the paper's Table 2; QUICK=1: a
# minute or two, on coarse meshes, into the report alone
QUICK ?=
DOCS = $(if $(QUICK),$(BUILD)/quick/docs,docs)
MEASURED = $(BUILD)/$(if $(QUICK),quick,report)
# peers: haptic libraries, beside whose proxies make bench times the servo (PEERS: where to fetch them)
.PHONY: peers
peers: $(patsubst host/bench/peers/%.cpp,$(BUILD)/peers/%.so,$(wildcard host/bench/peers/*.cpp))
$(BUILD)/peers/%.so: host/bench/peers/%.cpp host/bench/peers/peer.h scripts/peers.sh
	@PEERS="$(PEERS)" sh scripts/peers.sh $(@D) $*
# How far the bench is, in its time, and what begins now.
bench_step = @printf 'bench: [%-20s] %3d %%  %s\n' "$$(printf '%*s' $$(($(1) / 5)) '' | tr ' ' '\#')" $(1) "$(2)"
.PHONY: bench
bench: $(addprefix $(BUILD)/bin/,haptable-bench haptable-bench-devices haptable-bench-ticks haptable-contact) library lab $(if $(QUICK),,bench-programs)
	@$(MAKE) --no-print-directory -k peers || echo "a peer cannot be fetched here: its table stays as it is"
	@$(MAKE) --no-print-directory scene SCENE=meshes/cube.toml
	@$(MAKE) --no-print-directory scene SCENE=meshes/mouse.toml
	@rm -rf $(BUILD)/quick
	@mkdir -p $(MEASURED)
	$(call bench_step,5,speed of tick and picture)
	@$(LAB) speed $(MEASURED)/bench.json $(if $(QUICK),--repetitions 3)
	$(call bench_step,10,error against the body of every configuration)
	@$(LAB) error $(MEASURED)/error.json $(if $(QUICK),--quick)
	$(call bench_step,45,hard cases)
	@$(LAB) hard $(MEASURED)/hard.json
	@$(LAB) devices $(MEASURED)/devices.json
	@$(if $(QUICK),:,$(LAB) liver $(MEASURED)/liver.json)
	$(call bench_step,50,what contact feels like)
	@$(LAB) contact $(MEASURED)/contact.json $(if $(QUICK),--loops 20 --repetitions 3)
	@$(LAB) beside $(MEASURED)/beside.json $(if $(QUICK),--rounds 6)
	@$(if $(QUICK),cp -r docs $(DOCS),$(MAKE) --no-print-directory bench-target)
	@$(MAKE) --no-print-directory report

# What `make bench` counts on the microcontrollers' images, and how the inversion grows.
.PHONY: bench-programs bench-target
bench-programs: $(addprefix $(BUILD)/bin/,haptable-bench-inversion haptable-count) $(PAGE_PARTS) library $(BUILD)/setup-lab.stamp
bench-target: bench-programs
	@$(MAKE) --no-print-directory images
	$(call bench_step,60,instructions and bytes on the microcontrollers)
	@$(LAB) instructions $(BUILD)/cube $(BUILD)/mouse --out $(MEASURED)/instructions.json
	@$(LAB) target $(MEASURED)/target.json
	@$(LAB) sizes $(MEASURED)/size.json
	$(call bench_step,85,growth of the inversion)
	@$(LAB) inversion $(BUILD)/report/inversion.json

# bench-large: what takes too long for make bench, kept in docs/numbers.json: PART="large masks scale scan truth known large-strain stiffening elements elsewhere" (then: make report)
PART ?= large masks scale scan truth known large-strain stiffening elements elsewhere
.PHONY: bench-large
bench-large: $(MODULES) $(BUILD)/bin/haptable-precompute library lab
	@$(MAKE) --no-print-directory mpi
	@$(LAB) large $(PART)

# report: the newest numbers of $(BUILD)/report into docs/numbers.json, from there into the pages, build/report/index.html and CSV files
PAGES = $(if $(QUICK),,README.md CHANGELOG.md $(wildcard firmware/*.md)) $(patsubst docs/%,$(DOCS)/%,$(wildcard docs/*.md docs/design/*.md docs/data/*.csv))
.PHONY: report
report: $(BUILD)/setup-bench.stamp $(BUILD)/setup-lab.stamp
	@mkdir -p $(BUILD)/report $(MEASURED)
	@$(LAB) take --numbers $(DOCS)/numbers.json $(MEASURED) $(PAGES)
	@$(LAB) check --numbers $(DOCS)/numbers.json $(PAGES)
	@$(LAB) report --docs $(DOCS) $(BUILD)/report

# scene-keys: the tables of docs/SCENE.md and docs/scene.schema.json anew, from the keys' table (host/scene/keys.cpp)
.PHONY: scene-keys
scene-keys: $(BUILD)/bin/haptable-keys
	@$< | $(LAB_PYTHON) -m lab.scene_keys docs/SCENE.md docs/scene.schema.json

# figures: remake every picture of README and docs, or some (make figures FIGURES="states fingers")
FIGURES ?=
.PHONY: figures
figures: $(addprefix $(BUILD)/bin/,haptable-precompute haptable-view haptable-run haptable-device) library $(PAGE_PARTS)
	@sh scripts/setup.sh lab figures
	@for scene in cube cube-two mouse mouse-mask liver-capsule liver-spatula laws/fibres laws/bed free-cube grasp-cube jelly jelly-two; do $(MAKE) --no-print-directory scene SCENE=meshes/$$scene.toml || exit 1; done
	@$(LAB) figures $(FIGURES)

# lint: warnings as errors, clang-tidy and cppcheck on what we wrote, and the arrows between the folders
.PHONY: lint
lint: all $(BUILD)/tests/unit | $(BUILD)/setup-lint.stamp
	@BUILD=$(BUILD) sh scripts/lint.sh

# tidy: clang-tidy on the rooms that changed since it had nothing to say, in any clone (20 s a room)
# Not the servo's mains and the images' programs, which need a scene's model.h, nor the bench's, which is made of
# Google Benchmark's macros, nor a peer's, which needs that library.
TIDY = $(filter-out host/session/servo/main.cpp host/bench/main.cpp host/bench/peers/% $(if $(shell command -v mpicxx),,host/precompute/mpi/% host/inverse/mpi/%),\
    $(shell find host codegen -name '*.cpp') $(wildcard firmware/*.c) \
    $(patsubst %,firmware/port/%.c,haptable_memory haptable_scene_reader haptable_ticks measure))
.PHONY: tidy
tidy: $(patsubst %,$(BUILD)/tidy/%.ok,$(filter %.c,$(TIDY))) | $(BUILD)/setup-lint.stamp
	@$(if $(filter %.cpp,$(TIDY)),rooms=$$(sh scripts/units.sh --write 99999 $(BUILD)/tidy/UnifiedSource- $(filter %.cpp,$(TIDY))) && $(MAKE) --no-print-directory $$(echo "$$rooms" | sed 's/$$/.ok/'),:)

# format: put every C and C++ file into the project's form
.PHONY: format
format: $(BUILD)/setup-lint.stamp
	clang-format -i $$(git ls-files '*.c' '*.h' '*.cpp' '*.hpp')

# compile_commands.json: how each file is compiled, for editors and clang's tools; compiles nothing
.PHONY: compile_commands.json sources
sources: $(patsubst %,$(BUILD)/%.o,$(filter-out host/bench/% host/session/servo/main.cpp,$(HOST_FILES)) $(TEST_FILES) $(wildcard firmware/*.c))
compile_commands.json:
	@$(MAKE) -nB --no-print-directory PRECOMPILED= WERROR= COLLECT= sources 2>/dev/null | sh scripts/compile_commands.sh >$@.beside
	@mv $@.beside $@

# setup: install the Debian packages that are missing, for everything but microcontrollers, several machines and films
.PHONY: setup
setup: $(BUILD)/setup.stamp $(patsubst %,$(BUILD)/setup-%.stamp,surface test bench lab lint package)

# clean: remove what was made, but not people's tables
.PHONY: clean
clean:
	@sh scripts/clean.sh $(BUILD)

# distclean: remove everything that was made, tables too
.PHONY: distclean
distclean:
	@sh scripts/clean.sh $(BUILD) all

# help: this list
.PHONY: help
help:
	@sed -n 's/^# \([a-z_-]*\(\.json\)*\): \(.*\)/\1|\3/p' Makefile firmware/firmware.mk packaging/*.mk | awk -F'|' '{printf "  make %-12s %s\n", $$1, $$2}'

# `make V=1` prints whole commands.
Q = $(if $(V),,@)
say = @$(if $(V),:,printf '  %-8s %s\n')

# ---- how things are made -------------------------------------------------------------------------------------------

$(BUILD)/setup.stamp: scripts/setup.sh
	@sh scripts/setup.sh
	@mkdir -p $(@D) && touch $@

# What only a part of the project needs is installed with it.
$(BUILD)/setup-%.stamp: scripts/setup.sh | $(BUILD)/setup.stamp
	@sh scripts/setup.sh $*
	@mkdir -p $(@D) && touch $@

$(filter $(BUILD)/host/mesh/cgal/%,$(IN_MODULES)) $(BUILD)/host/strokes/solid.cpp.o: | $(BUILD)/setup-surface.stamp
$(TEST_OBJECTS): | $(BUILD)/setup-test.stamp $(if $(PRECOMPILED),$(BUILD)/tests/precompiled.hpp.gch)
$(TEST_OBJECTS): private precompiled = $(if $(PRECOMPILED),$(BUILD)/tests/precompiled.hpp.gch)
# A fifth less of the compiler's time, and the tests' own loops are short.
$(TEST_OBJECTS) $(BUILD)/tests/precompiled.hpp.gch: private OPT = -O1 -finline-small-functions
$(BUILD)/tests/precompiled.hpp.gch: | $(BUILD)/setup-test.stamp
$(patsubst %,$(BUILD)/%.o,$(filter host/bench/%,$(HOST_FILES))) $(call objects,host/bench): | $(BUILD)/setup-bench.stamp

$(BUILD)/%.cpp.o: %.cpp | $(BUILD)/setup.stamp $(TYPES) $(precompiled)
	$(say) C++ $<
	@mkdir -p $(@D)
	$(Q)$(COMPILE) -c $< -o $@

$(UNITS) &: $(UNITED) scripts/units.sh
	@$(call write_units,--write) >/dev/null

$(UNITS:%=%.o): %.o: % | $(BUILD)/setup.stamp $(TYPES) $(precompiled)
	$(say) C++ $<
	$(Q)$(COMPILE) -c $< -o $@

# Beside a copy, which the compiler reads where it does not take the other. Remade when a header that it holds is newer.
$(BUILD)/%/precompiled.hpp.gch: %/precompiled.hpp | $(BUILD)/setup.stamp
	$(say) C++ $<
	@mkdir -p $(@D)
	@cp $< $(@:.gch=)
	$(Q)$(CXX) $(filter-out -MMD,$(CXXFLAGS)) -MD -MF $@.d -x c++-header -c $< -o $@

$(BUILD)/%.c.o: %.c | $(BUILD)/setup.stamp
	$(say) C $<
	@mkdir -p $(@D)
	$(Q)$(CC) $(CFLAGS) -c $< -o $@

tidied = $(say) TIDY $< && mkdir -p $(@D) && sh scripts/tidy.sh $(1) $< $(2) && $(1) $(2) -MM -MP -MT $@ -MF $@.d $< && touch $@

$(BUILD)/tidy/%.cpp.ok: $(BUILD)/tidy/%.cpp tests/clang-tidy.yaml scripts/tidy.sh | $(BUILD)/setup-lint.stamp $(TYPES)
	$(call tidied,$(CXX),-std=c++20 $(INCLUDE))

$(BUILD)/tidy/%.c.ok: %.c tests/clang-tidy.yaml scripts/tidy.sh | $(BUILD)/setup-lint.stamp
	$(call tidied,$(CC),-std=c99 -Ifirmware)

$(BUILD)/lcm/haptable/%.hpp: codegen/lcm/%.lcm | $(BUILD)/setup.stamp
	$(say) LCM $<
	@mkdir -p $(BUILD)/lcm
	$(Q)lcm-gen --lazy -x --cpp-hpath $(BUILD)/lcm $<
	@touch $@

$(BUILD)/lcm/haptable/channels.hpp: codegen/lcm/channels.list
	@mkdir -p $(@D)
	@awk '!/^#/ { types = types "#include \"haptable/" $$2 ".hpp\"\n"; rows = rows sprintf("    X(%s, %s, %s, %d) \\\n", $$1, $$2, $$3, $$4 == "each" ? 8 : 1) } \
	END { print "#pragma once\n" types "#define HAPTABLE_MESSAGES(X) \\\n" rows }' $< > $@

# The servo for a browser: freestanding, with the host's bits (FP), all modes in one module that reads its tables.
WASM_C = $(wildcard firmware/*.c host/page/wasm/*.c) $(addprefix firmware/port/haptable_,scene_reader.c memory.c)
WASM_H = $(wildcard firmware/*.h host/page/wasm/*.h) firmware/port/haptable_scene_reader.h
WASM_FLAGS = --target=wasm32 -std=c99 -ffreestanding -nostdlib -O2 $(FP) -Wall -Wextra -Wshadow -Wconversion -pedantic $(if $(WERROR),-Werror) \
    -Ifirmware -Ifirmware/port -fuse-ld=lld -Wl,--no-entry -Wl,--gc-sections -Wl,--strip-all

$(BUILD)/lib/page/servo.wasm: $(WASM_C) $(WASM_H) | $(BUILD)/setup-touch.stamp
	$(say) WASM $@
	@mkdir -p $(@D)
	$(Q)clang $(WASM_FLAGS) -o $@ $(WASM_C)

$(BUILD)/lib/page/three.min.js: | $(BUILD)/setup-touch.stamp
	@mkdir -p $(@D)
	@cp /usr/share/javascript/three/three.min.js $@

$(BUILD)/lib/page/%: host/page/web/%
	@mkdir -p $(@D)
	@cp $< $@

# What speaks to our programs in tests and is not ours; and what tests of packages install.
$(BUILD)/python/ready $(BUILD)/python/wheels/ready: scripts/python.sh | $(BUILD)/setup-test.stamp
	$(say) PYTHON $(@D)
	$(Q)sh scripts/python.sh $(@D)
	@touch $@

# haptable.messages of Python: lcm-gen makes a package of the types' own name, which is the whole package's.
PYTHON_TYPES = $(BUILD)/python/types/haptable/messages/__init__.py
$(PYTHON_TYPES): $(wildcard codegen/lcm/*.lcm) codegen/lcm/channels.list | $(BUILD)/setup.stamp
	$(say) LCM $(@D)
	@rm -rf $(BUILD)/python/types && mkdir -p $(BUILD)/python/types/haptable
	$(Q)lcm-gen -p --ppath $(BUILD)/python/types/made $(filter %.lcm,$^)
	@mv $(BUILD)/python/types/made/haptable $(@D) && rmdir $(BUILD)/python/types/made
	@awk 'BEGIN { print "\n#: The type of the messages on each channel.\nCHANNELS = {" } !/^#/ { printf "    \"%s\": %s,\n", $$1, $$2; for (i = 2; $$4 == "each" && i <= 8; ++i) printf "    \"%s_%d\": %s,\n", $$1, i, $$2 } END { print "}" }' $(filter %.list,$^) >> $@

link = @$(if $(V),set -x,printf '  %-8s %s\n' LINK $@); mkdir -p $(@D); $(CXX) $(LDFLAGS) -o $@ $(sort $(filter %.o,$^))

$(BUILD)/lib/haptable-gmsh.so: $(filter $(BUILD)/host/mesh/gmsh/%,$(IN_MODULES))
	$(link) -shared -lgmsh $(LIBS_BASE)

$(BUILD)/lib/haptable-cgal.so: $(filter $(BUILD)/host/mesh/cgal/%,$(IN_MODULES))
	$(link) -shared -lgmp -lmpfr $(LIBS_BASE)

$(BUILD)/bin/haptable-precompute: $(BUILD)/host/precompute/main.cpp.o $(PRECOMPUTE)
	$(link) $(LIBS_PRECOMPUTE)

$(BUILD)/bin/haptable-precompute-mpi: $(BUILD)/host/precompute/mpi/main.cpp.o $(MPI)
	$(link) $(LIBS_MPI)

# The tests of an Inverse, for ranks of MPI; tests/host/mpi/mpi_test.cpp runs it.
$(BUILD)/tests/ranks: $(patsubst %,$(BUILD)/tests/%.cpp.o,host/mpi/ranks/main host/inverse/inverse_test bodies cells conditioning dense pressures tolerance) $(MPI)
	$(link) -lgtest $(LIBS_MPI)

$(BUILD)/bin/haptable-codegen: $(BUILD)/codegen/main.cpp.o $(CODEGEN)
	$(link) $(LIBS_BASE)

$(BUILD)/bin/haptable-device: $(BUILD)/host/device/main.cpp.o $(DEVICE)
	$(link) $(LIBS_DEVICE)

$(BUILD)/bin/haptable-run: $(BUILD)/host/run/main.cpp.o $(RUN)
	$(link) $(LIBS_LINK)

$(BUILD)/bin/haptable-keys: $(BUILD)/host/scene/main.cpp.o $(SCENES)
	$(link) $(LIBS_BASE)

$(BUILD)/bin/haptable-fit: $(BUILD)/host/fit/main.cpp.o $(FIT)
	$(link) $(LIBS_LINK)

# The second is a package's: packaging/install.mk says of which objects.
$(BUILD)/bin/haptable-view: $(BUILD)/host/page/live/main.cpp.o $(LIVE)
$(BUILD)/bin/haptable-view $(BUILD)/package/deb/bin/haptable-view:
	$(link) -lwebsockets $(LIBS_VIEW)

$(BUILD)/bin/haptable-bridge: $(BUILD)/host/session/bridge/main.cpp.o $(BRIDGE)
	$(link) $(LIBS_LINK)

$(BUILD)/bin/haptable-count: $(BUILD)/host/target/main.cpp.o $(TARGETED)
	$(link) $(LIBS_BASE)

$(BUILD)/bin/haptable-bench: $(BUILD)/host/bench/main.cpp.o $(BENCH)
	$(link) -lbenchmark $(LIBS_VIEW) $(LIBS_PRECOMPUTE)

$(BUILD)/bin/haptable-contact: $(BUILD)/host/bench/contact/main.cpp.o $(BUILD)/host/bench/subject.cpp.o $(TARGETED)
	$(link) $(LIBS_BASE)

$(BUILD)/bin/haptable-bench-ticks: $(BUILD)/host/bench/ticks/main.cpp.o $(BUILD)/host/bench/subject.cpp.o $(CODEGEN)
	$(link) $(LIBS_BASE)

$(BUILD)/bin/haptable-strokes: $(BUILD)/host/strokes/main.cpp.o $(STROKES)
	$(link) $(LIBS_STROKES)

$(BUILD)/bin/haptable-bench-inversion: $(BUILD)/host/bench/inversion/main.cpp.o $(PRECOMPUTE)
	$(link) $(LIBS_PRECOMPUTE)

$(BUILD)/bin/haptable-bench-realtime: $(BUILD)/host/bench/realtime/main.cpp.o $(LINK)
	$(link) $(LIBS_LINK)

$(BUILD)/bin/haptable-bench-devices: $(BUILD)/host/bench/devices/main.cpp.o $(DEVICE) $(CODEGEN)
	$(link) $(LIBS_DEVICE)

$(BUILD)/tests/unit: $(TESTS) $(BUILD)/host/page/wasm/hand.c.o $(PRECOMPUTE) $(STROKES) $(SERVO) $(BRIDGE) $(RUN) $(FIT) $(LIVE) $(TARGETED) $(call objects,host/library) | $(MODULES) $(PYTHON_TYPES)
	$(link) -lgtest_main -lgtest -lwebsockets $(LIBS_VIEW) $(LIBS_STROKES)

$(BUILD)/tests/soak/soak: $(patsubst %,$(BUILD)/tests/%.cpp.o,soak/main loop/faulty_session shapes) $(SERVO) $(DEVICE) $(CODEGEN)
	$(link) -lgtest $(LIBS_DEVICE)

# One scene: `make scene` calls make again with its NAME.
ifneq ($(NAME),)
HERE = $(BUILD)/$(NAME)

$(HERE)/summary.json $(HERE)/model.c $(HERE)/model.h $(HERE)/display.c:
	@echo "make: $@ is missing: make scene SCENE=... makes it" >&2; exit 1

$(HERE)/model.c.o: $(HERE)/model.c $(HERE)/model.h $(wildcard firmware/*.h)
	$(say) C $(HERE)/model.c
	$(Q)$(CC) $(CFLAGS) -c $(HERE)/model.c -o $@

$(HERE)/servo.o: host/session/servo/main.cpp $(HERE)/model.h $(wildcard firmware/*.h) | $(precompiled)
	$(say) C++ $<
	$(Q)$(COMPILE) -I$(HERE) -Ifirmware -c $< -o $@

$(HERE)/servo: $(HERE)/servo.o $(HERE)/model.c.o $(SERVO)
	$(link) $(LIBS_LINK)

endif

include firmware/firmware.mk
include packaging/install.mk

# A source that has moved, which the .d of an older build names: what was made of it is made anew.
host/%.cpp: ;
codegen/%.cpp: ;

# What compilers wrote, but not in the folders that are builds of their own; of one scene's images, their own.
COMPILED = $(if $(filter scene-images,$(MAKECMDGOALS)),$(addsuffix /firmware/$(TARGET),$(BUILD) $(BUILD)/$(NAME)),$(BUILD))
-include $(shell find $(COMPILED) \( -path $(BUILD)/against -o -path $(BUILD)/sanitize \) -prune -o -name '*.d' -not -name scene.d -print 2>/dev/null)
