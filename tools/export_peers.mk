# Gets what exports are tested in and no system packages: make -f tools/export_peers.mk -j2
# `node`: interpreters of statecharts and MicroPython, from npm, for Node.
# `behaviortree_cpp`: BehaviorTree.CPP, compiled from its sources in the source distribution of behaviortreepy.

PIP ?= .venv/bin/pip
NODE = build/node_peers
OUT = build/behaviortree_cpp
S = $(OUT)/source
LIBRARY = $(OUT)/lib/libbehaviortree_cpp.so
KEPT = $(wildcard $S/src/*.cpp $S/src/actions/*.cpp $S/src/decorators/*.cpp $S/src/controls/*.cpp)
SOURCES = $(filter-out %_WIN.cpp %/example.cpp %/manual_node.cpp,$(KEPT)) $S/3rdparty/tinyxml2/tinyxml2.cpp
OBJECTS = $(patsubst %.cpp,$(OUT)/objects/%.o,$(notdir $(SOURCES)))
THIRD = $(addprefix -I$S/3rdparty/,. lexy/include tinyxml2 minicoro minitrace flatbuffers)
FLAGS = -std=c++17 -O0 -fPIC -w -DLEXY_HAS_UNICODE_DATABASE -DLEXY_EXPERIMENTAL -DBTCPP_LIBRARY_VERSION='"4.8.2"'

.PHONY: all node behaviortree_cpp
all: node behaviortree_cpp

node: $(NODE)/node_modules/.package-lock.json

$(NODE)/node_modules/.package-lock.json: $(wildcard tools/node_peers/*.json) tools/node_peers/.npmrc
	mkdir -p $(NODE)
	cp $^ $(NODE)
	npm ci --silent --prefix $(NODE) </dev/null
	touch $@

behaviortree_cpp: $S/package.xml
	+$(MAKE) -f tools/export_peers.mk $(LIBRARY)

$S/package.xml: requirements-dev.lock
	mkdir -p $(OUT)/lib $(OUT)/objects
	sed -n '/^behaviortreepy==/,/[^\\]$$/p' requirements-dev.lock > $(OUT)/requirements.txt
	$(PIP) download --quiet --no-deps --no-binary :all: --require-hashes -r $(OUT)/requirements.txt --dest $(OUT)
	tar -xzf $(OUT)/behaviortreepy-*.tar.gz -C $(OUT)
	rm -rf $S && mv $(OUT)/behaviortreepy-*/BehaviorTree.CPP $S
	ln -sfn source/include $(OUT)/include
	touch $@

vpath %.cpp $(sort $(dir $(SOURCES)))
$(OUT)/objects/%.o: %.cpp
	$(CXX) $(FLAGS) -I$S/include -I$S $(THIRD) -c $< -o $@

$(LIBRARY): $(OBJECTS)
	$(CXX) -shared $^ -ldl -pthread -o $@
