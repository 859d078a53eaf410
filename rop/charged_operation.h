// A technique's operation with its costs counted: the table of its control paths, and single operations.
#pragma once

#include "rop/operation_of.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ropsim {

namespace detail {
// The next script of decisions in binary order; false when all have been run.
inline bool next_script(std::vector<bool>& script) {
    while (!script.empty() && script.back()) script.pop_back();
    if (script.empty()) return false;
    script.back() = true;
    return true;
}
inline constexpr int kEnumerationNodes = 64;
}  // namespace detail

template <Technique T>
void OperationOf<T>::add_path(CostTable& table, const DatapathShape& shape, int path, int pass,
                              const Work& work, const ChargedDatapath& d, const PixelAccess& access) const {
    PathCost& entry = table.at(static_cast<std::size_t>(path));
    const bool first = entry.name.empty();
    CHECK(first || (entry.pass == pass && entry.work == work), "path '{}' is reached with different work",
          declaration().paths[static_cast<std::size_t>(path)]);
    entry.name = declaration().paths[static_cast<std::size_t>(path)];
    entry.pass = pass;
    entry.work = work;
    entry.step = d.step_work;
    entry.has_step = d.step_known;
    entry.interval = initiation_interval(work, shape);
    for (std::size_t k = 0; k < 2; ++k)
        entry.step_interval[k] = d.step_known[k] ? initiation_interval(d.step_work[k], shape) : 0;
    for (std::size_t s = 0; s < kMaxTechniqueSurfaces; ++s) {
        entry.worst[s].read |= access[s].read;
        entry.worst[s].write |= access[s].write;
    }
}

// Runs the operation once for every sequence of decisions it can take, on a cleared pixel whose values do not
// matter: decisions come from the script. So the table holds every control path, whether a scene reaches it
// or not.
template <Technique T>
CostTable OperationOf<T>::cost(const DatapathShape& shape) const {
    const Declaration& declared = declaration();
    CostTable table(declared.paths.size());
    TraceHeader one_pixel;
    one_pixel.width = one_pixel.height = 1;
    const int passes = static_cast<int>(declared.passes.size());
    for (int pass = kResolvePass; pass < passes; ++pass) {
        if (pass == kResolvePass && !declared.resolves) continue;
        std::vector<bool> script;
        do {
            PixelStore store(declared, one_pixel, detail::kEnumerationNodes, pixel_constant());
            const StoreMap stores(1, 1, {&store});
            if (store.pool() != nullptr) store.pool()->allocate();  // a node for one step of a list
            PixelAccess access{};
            ChargedDatapath d(&script);
            const Ledger ledger(shape);
            std::uint32_t* words = store.pixel(0, 0);
            ChargedPixel pixel(words, access, store.pool(), /*worst=*/true);
            int path = 0;
            if (pass == kResolvePass && declared.gathers) {
                path = run_gather(d, stores, pixel, 0, 0, true).path;
            } else if (pass == kResolvePass && declared.footprint > 0) {
                HaloTile halo(stores, 0, 0, declared.footprint);
                Window<ChargedPixel> window(halo, 0, 0, access, true);
                run_window(d, window, path);
            } else if (pass == kResolvePass) {
                PixelBackground background = store.background(0, 0);
                background.samples = screen_.samples;
                path = run_resolve(d, background, pixel).path;
            } else if (declared.passes[static_cast<std::size_t>(pass)].gathers) {
                path = run_gather_pass(d, pass, stores, pixel, 0, 0, true);
            } else if (declared.passes[static_cast<std::size_t>(pass)].kind == PassKind::kImage) {
                path = run_image_pass(d, pass, pixel);
            } else {
                const Fragment f{0.5f, 0.25f, 0.25f, 0.25f, 0.5f, 0, 0, 0, 0xFFFF, 0};
                FragmentInput<ChargedDatapath> in;
                set_input(in, pass, f, {}, 0, words, store);
                if constexpr (HasShader<T>) put_exports(in, shaded(pass, f, {}, store));
                path = technique_.fragment(d, pass, in, pixel);
            }
            add_path(table, shape, path, pass, ledger.work(), d, access);
        } while (detail::next_script(script));
    }
    for (std::size_t p = 0; p < table.size(); ++p)
        CHECK(!table[p].name.empty(), "path '{}' is never taken", declared.paths[p]);
    return table;
}

template <Technique T>
ChargedOutcome OperationOf<T>::charged_fragment(const DatapathShape& shape, int pass, int round,
                                                const Fragment& fragment, const FragmentChannels& channels,
                                                PixelStore& store) const {
    ChargedOutcome outcome;
    const Ledger ledger(shape);
    ChargedDatapath d;
    std::uint32_t* words = store.pixel(fragment.x, fragment.y);
    ChargedPixel pixel(words, outcome.access, store.pool(), /*worst=*/false);
    FragmentInput<ChargedDatapath> in;
    set_input(in, pass, fragment, channels.slope, round, words, store);
    if constexpr (HasShader<T>) put_exports(in, shaded(pass, fragment, channels.material, store));
    outcome.path = technique_.fragment(d, pass, in, pixel);
    outcome.work = ledger.work();
    outcome.steps = d.step_count;
    outcome.step_work = d.step_work;
    return outcome;
}

template <Technique T>
ChargedOutcome OperationOf<T>::charged_image_pass(const DatapathShape& shape, int pass, int,
                                                  PixelStore& store, const StoreMap& stores, int x,
                                                  int y) const {
    ChargedOutcome outcome;
    const Ledger ledger(shape);
    ChargedDatapath d;
    ChargedPixel pixel(store.pixel(x, y), outcome.access, store.pool(), /*worst=*/false);
    if (declaration().passes[static_cast<std::size_t>(pass)].gathers) {
        outcome.path = run_gather_pass(d, pass, stores, pixel, x, y, false);
    } else {
        outcome.path = run_image_pass(d, pass, pixel);
    }
    outcome.work = ledger.work();
    outcome.steps = d.step_count;
    outcome.step_work = d.step_work;
    return outcome;
}

template <Technique T>
ChargedOutcome OperationOf<T>::charged_resolve(const DatapathShape& shape, PixelStore& store,
                                               const StoreMap& stores, int x, int y, float* rgb) const {
    ChargedOutcome outcome;
    const Ledger ledger(shape);
    ChargedDatapath d;
    Rgb<ChargedDatapath> color;
    if (declaration().gathers) {
        ChargedPixel pixel(store.pixel(x, y), outcome.access, store.pool(), /*worst=*/false);
        const Resolved<ChargedDatapath> resolved = run_gather(d, stores, pixel, x, y, false);
        color = resolved.color;
        outcome.path = resolved.path;
    } else if (declaration().footprint > 0) {
        HaloTile halo(stores, x / kTileSize, y / kTileSize, declaration().footprint);
        Window<ChargedPixel> window(halo, x % kTileSize, y % kTileSize, outcome.access, false);
        color = run_window(d, window, outcome.path);
    } else {
        ChargedPixel pixel(store.pixel(x, y), outcome.access, store.pool(), /*worst=*/false);
        const Resolved<ChargedDatapath> resolved = run_resolve(d, store.background(x, y), pixel);
        color = resolved.color;
        outcome.path = resolved.path;
    }
    write_color({color.r.value, color.g.value, color.b.value}, rgb);
    outcome.work = ledger.work();
    outcome.steps = d.step_count;
    outcome.step_work = d.step_work;
    if (store.pool() != nullptr) store.pool()->visited().clear();
    return outcome;
}

}  // namespace ropsim
