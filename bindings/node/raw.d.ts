// SPDX-License-Identifier: MIT

/* htree.h, one to one. Nothing here is checked, and a wrong pointer ends the process. */

/** An address, memory, or NULL. */
export type Pointer = bigint | ArrayBufferView | null;

/** A struct by the names of its fields in htree.h. */
export type Struct = Record<string, unknown>;

/** koffi's types of the structs and callbacks, by their names in htree.h. */
export const types: Readonly<Record<
    | 'htree_object_intersect' | 'htree_report' | 'htree_ray' | 'htree_hit' | 'htree_box'
    | 'htree_objects' | 'htree_mesh' | 'htree_progress' | 'htree_allocator' | 'htree_tasks'
    | 'htree_options' | 'htree_load_options' | 'htree_query' | 'htree_stats' | 'htree_view',
    object>>;

export function htree_version(): number;
export function htree_status_name(status: number): string;
export function htree_error_text(): string;
export function htree_kind_name(kind: number): string | null;
export function htree_kind_from_name(name: string | null): number;
export function htree_options_init(options: Struct | null, size: number, kind: number): number;
export function htree_calibrate(options: Struct | null): number;
export function htree_build(
    out: [bigint | null] | null, mesh: Struct | null, options: Struct | null): number;
export function htree_complete(tree: Pointer): number;
export function htree_update(
    tree: Pointer, mesh: Struct | null, how: number, quality: [number] | null): number;
export function htree_free(tree: Pointer): void;
export function htree_query_init(query: Struct | null, size: number): number;
export function htree_intersect(
    tree: Pointer, rays: Pointer, count: number, hits: Pointer, query: Struct | null): number;
export function htree_occluded(
    tree: Pointer, rays: Pointer, count: number, occluded: Pointer, query: Struct | null): number;
export function htree_save(
    tree: Pointer, file: Pointer, size: number, bytes: [number | bigint | null] | null): number;
export function htree_load_options_init(options: Struct | null, size: number): number;
export function htree_load(
    out: [bigint | null] | null, file: Pointer, size: number, options: Struct | null): number;
export function htree_get_bounds(tree: Pointer, bounds: Struct | null): number;
export function htree_get_stats(tree: Pointer, stats: Struct | null): number;
export function htree_get_view(tree: Pointer, view: Struct | null): number;
export function htree_check(tree: Pointer): number;
