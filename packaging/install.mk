# haptable on a system: programs, what they read, and what others build on. Included by the Makefile.
#
#   programs, modules, pages, firmware sources -> PREFIX, each file listed in PREFIX/share/haptable/installed.txt

PREFIX ?= /usr/local
DESTDIR ?=
# Of libraries that others link: Debian's packages have it elsewhere.
LIBDIR ?=
$(call as_given,PREFIX)
$(call as_given,DESTDIR)
$(call as_given,LIBDIR)
# What haptable-codegen --export takes: one list of files for every kind of project.
BOARD_PARTS = $(patsubst firmware/%,$(BUILD)/lib/firmware/%,$(wildcard firmware/*.[ch])) \
    $(patsubst packaging/%,$(BUILD)/lib/%,$(shell find packaging/boards -type f))
# What was one before: no source any more.
BOARD_STALE = $(filter-out $(BOARD_PARTS),$(wildcard $(BUILD)/lib/firmware/*))
LIBRARY = $(BUILD)/lib/libhaptable.so.1
INSTALLED = $(addprefix $(BUILD)/bin/,haptable-precompute haptable-codegen haptable-device haptable-view haptable-bridge haptable-run haptable-fit)
MANUAL = $(patsubst $(BUILD)/bin/%,$(BUILD)/package/man/%.1,$(INSTALLED)) $(BUILD)/package/man/haptable-build.1

# install: programs, manuals, libraries and sources into DESTDIR/PREFIX (make install PREFIX=$HOME/.local)
.PHONY: install
install: $(INSTALLED) $(MODULES) $(PAGE_PARTS) $(BUILD)/lib/libhaptable-servo.a $(LIBRARY) $(MANUAL)
	@BUILD=$(BUILD) sh packaging/install.sh "$$HAPTABLE_DESTDIR" "$$HAPTABLE_PREFIX" "$${HAPTABLE_LIBDIR:-$$HAPTABLE_PREFIX/lib}"

# uninstall: remove what make install put there
.PHONY: uninstall
uninstall:
	@sh packaging/uninstall.sh "$$HAPTABLE_DESTDIR" "$$HAPTABLE_PREFIX"

$(BUILD)/bin/haptable-codegen: | $(BOARD_PARTS) $(if $(BOARD_STALE),board-stale)

.PHONY: board-stale
board-stale:
	@rm -f $(BOARD_STALE)

$(BUILD)/lib/firmware/%: firmware/%
	@mkdir -p $(@D)
	@cp $< $@

$(BUILD)/lib/boards/%: packaging/boards/%
	@mkdir -p $(@D)
	@cp $< $@

# The servo of any scene, but for its tables: haptable-build links it.
$(BUILD)/lib/libhaptable-servo.a: $(SERVO)
	$(say) AR $@
	@mkdir -p $(@D)
	@rm -f $@
	$(Q)ar rcsD $@ $(sort $^)

# Of what each program says of itself.
manual = @mkdir -p $(@D); help2man --no-info --include packaging/man.txt --name "$$(sh packaging/purpose.sh $(1))" --output $@ $(1)

$(BUILD)/package/man/%.1: $(BUILD)/bin/% packaging/man.txt packaging/purpose.sh | $(BUILD)/setup-package.stamp
	$(say) MAN $@
	$(call manual,$<)

$(BUILD)/package/man/haptable-build.1: packaging/haptable-build packaging/man.txt $(BUILD)/bin/haptable-precompute | $(BUILD)/setup-package.stamp
	$(say) MAN $@
	@mkdir -p $(BUILD)/package/bin && cp packaging/haptable-build $(BUILD)/package/bin/ && cp $(BUILD)/bin/haptable-precompute $(BUILD)/package/bin/
	$(call manual,$(BUILD)/package/bin/haptable-build)

# The library: the firmware and codegen's tables in memory, for others to link. The programs have the same objects.
.PHONY: library
library: $(LIBRARY)
LIBRARY_C = $(patsubst %,$(BUILD)/%.o,$(wildcard firmware/*.c))
IN_LIBRARY = $(patsubst %,%.o,$(filter $(BUILD)/units/library/%,$(UNITS)))
SHARED = -fPIC -ffunction-sections -fdata-sections
SHARED_PRECOMPILED = $(if $(PRECOMPILED),$(BUILD)/host/library/precompiled.hpp.gch)

$(LIBRARY_C): private CFLAGS += $(SHARED) -fvisibility=hidden
$(IN_LIBRARY): private precompiled = $(SHARED_PRECOMPILED)
$(IN_LIBRARY): host/library/precompiled.hpp | $(SHARED_PRECOMPILED)
$(IN_LIBRARY) $(SHARED_PRECOMPILED): private CXXFLAGS += $(SHARED) -fno-semantic-interposition

$(LIBRARY): $(IN_LIBRARY) $(LIBRARY_C) host/library/exports.map
	$(link) -shared -Wl,-soname,$(@F) -Wl,--version-script=host/library/exports.map -Wl,-z,defs -Wl,--gc-sections $(LIBS_BASE)
	@ln -sf $(@F) $(@D)/libhaptable.so

# What the Python package holds besides its own text: pip install . makes it.
.PHONY: python-parts
PYTHON_PARTS = $(BUILD)/package/python
python-parts: $(PYTHON_PARTS)/libhaptable.so.1 $(PYTHON_PARTS)/messages/__init__.py

$(PYTHON_PARTS)/libhaptable.so.1: $(LIBRARY)
	@mkdir -p $(@D)
	@cp $< $@
	@ln -sf $(@F) $(@D)/libhaptable.so

$(PYTHON_PARTS)/messages/__init__.py: $(PYTHON_TYPES)
	@rm -rf $(@D) && mkdir -p $(@D)
	@cp $(<D)/*.py $(@D)/

# wheel: the Python package for this machine's Python, in build/package/wheel
.PHONY: wheel
wheel: python-parts | $(BUILD)/setup-package.stamp
	@[ -x $(BUILD)/package/venv/bin/pip ] || python3 -m venv $(BUILD)/package/venv
	$(Q)BUILD=$(BUILD) $(BUILD)/package/venv/bin/pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir $(BUILD)/package/wheel .
	@ls -s $(BUILD)/package/wheel

# deb: Debian packages of programs, library and header, in build/package/deb, and what lintian says of them
.PHONY: deb
DEB = $(BUILD)/package/deb
deb: $(DEB)/bin/haptable-view | $(BUILD)/setup-package.stamp
	@$(MAKE) --no-print-directory install DESTDIR=$(DEB)/stage PREFIX=/usr LIBDIR=/usr/lib/$$(dpkg-architecture -qDEB_HOST_MULTIARCH) >/dev/null
	@cp $< $(DEB)/stage/usr/bin/
	@rm -f $(DEB)/*.deb
	@sh packaging/deb.sh $(DEB)/stage $(DEB)
	@lintian --fail-on error $(DEB)/*.deb

# deb-tried: the packages installed into an empty Debian, and a force there
.PHONY: deb-tried
deb-tried: deb
	@sh packaging/clean-root.sh $(DEB)

# For every processor of the kind, not for this machine's.
$(DEB)/deformation.o: host/view/deformation.cpp | $(BUILD)/setup.stamp $(TYPES)
	$(say) C++ $<
	@mkdir -p $(@D)
	$(Q)$(CXX) $(CXXFLAGS) -O3 -c $< -o $@

$(DEB)/bin/haptable-view: $(BUILD)/host/page/live/main.cpp.o $(filter-out %/view/deformation.cpp.o,$(LIVE)) $(DEB)/deformation.o

# bench-ways: size and time of each way from nothing to a force, and of a tick from Python beside C (then: make report)
.PHONY: bench-ways
bench-ways: all library $(BUILD)/python/wheels/ready | $(BUILD)/setup-package.stamp $(BUILD)/setup-cross.stamp
	@mkdir -p $(BUILD)/report
	@BUILD=$(BUILD) python3 packaging/ways.py $(BUILD)/report/ways.json
	@BUILD=$(BUILD) $(BUILD)/package/ways/venv/bin/python python/tests/measure.py $(BUILD)/report/python.json

# manifests: write again what makes the firmware a library of Arduino, PlatformIO, ESP-IDF, Zephyr, CMake and CMSIS-Pack
.PHONY: manifests
manifests:
	@sh packaging/manifests.sh .

# Its tests export from there.
$(BUILD)/tests/unit: | $(BOARD_PARTS)
