{{- define "ccdt.name" -}}
{{- if contains .Chart.Name .Release.Name }}{{ .Release.Name }}{{ else }}{{ .Release.Name }}-{{ .Chart.Name }}{{ end }}
{{- end }}

{{/* The labels that select the pods. They must never change. */}}
{{- define "ccdt.selector" -}}
app.kubernetes.io/name: {{ .Chart.Name }}
app.kubernetes.io/instance: {{ .Release.Name }}
{{- end }}

{{- define "ccdt.labels" -}}
{{ include "ccdt.selector" . }}
app.kubernetes.io/version: {{ .Chart.AppVersion | quote }}
app.kubernetes.io/managed-by: {{ .Release.Service }}
helm.sh/chart: {{ .Chart.Name }}-{{ .Chart.Version }}
{{- end }}

{{/* The kind of the resource that creates the pods. */}}
{{- define "ccdt.workload" -}}
{{- if eq .Values.store.kind "disk" }}StatefulSet{{ else }}Deployment{{ end }}
{{- end }}

{{/* A value of any type as text. Helm reads integers as floats, and prints large ones with an exponent. */}}
{{- define "ccdt.text" -}}
{{- if not (kindIs "float64" .) }}{{ . }}
{{- else if eq . (floor .) }}{{ int64 . }}
{{- else }}{{ . }}
{{- end }}
{{- end }}

{{- define "ccdt.redisSecret" -}}
{{- .Values.store.redis.existingSecret | default (printf "%s-redis" (include "ccdt.name" .)) }}
{{- end }}

{{/* The name of the Secret with API keys; empty if there are none. */}}
{{- define "ccdt.keysSecret" -}}
{{- if .Values.keys.existingSecret }}{{ .Values.keys.existingSecret }}
{{- else if .Values.keys.list }}{{ include "ccdt.name" . }}-keys
{{- end }}
{{- end }}
